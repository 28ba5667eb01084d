# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator: the path of one image, its guard, and the state kept over a restart.

May import the rooms of core up to tracker.
"""
