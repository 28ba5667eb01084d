# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""References: association of tracks with objects of known position, and correction of all robots.

May import the rooms of core up to identity.
"""
