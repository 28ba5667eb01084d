# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reading and writing of bags through `rosbags`, without ROS."""
