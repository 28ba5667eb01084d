# SPDX-License-Identifier: Apache-2.0
"""Geometry, telemetry and estimation: numpy and scipy only, no ROS."""
