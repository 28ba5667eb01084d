# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""References: which tracks are things of known position, and what follows for all robots.

May import the rooms of core up to identity.
"""
