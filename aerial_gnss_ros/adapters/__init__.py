# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Converts vehicles' messages and logs to core values, and results to messages; no ROS import."""
