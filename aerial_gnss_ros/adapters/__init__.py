# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Vehicles' messages and logs in, results out, by attribute only; no ROS import."""
