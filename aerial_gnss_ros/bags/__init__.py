# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recorded bags in and out, through `rosbags`: no ROS needed."""
