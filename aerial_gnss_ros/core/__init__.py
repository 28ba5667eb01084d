# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Geometry, telemetry and estimation: numpy and scipy only, no ROS."""
