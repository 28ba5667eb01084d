# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data association: which box belongs to which track, with gates and clutter.

May import the rooms of core up to filter.
"""
