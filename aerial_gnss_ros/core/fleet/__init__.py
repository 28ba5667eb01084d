# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several drones that see the same robots: one filter of all, and which robot is which.

May import the rooms of core up to estimation.
"""
