# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Models of the filter: motion of robots and camera, platform errors, measurements.

May import the rooms of core up to georeferencing.
"""
