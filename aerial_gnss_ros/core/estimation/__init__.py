# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator: one image's way through all rooms, its guard, and what survives a restart.

May import the rooms of core up to tracker.
"""
