# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames, WGS84, the geoid, gimbals, magnetic north, the local map, the water's surface.

May import values and numerics.
"""
