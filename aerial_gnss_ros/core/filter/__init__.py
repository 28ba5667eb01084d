# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The joint filter of platform errors and robots: prediction, update, image latency.

May import text and the rooms of core up to faults.
"""
