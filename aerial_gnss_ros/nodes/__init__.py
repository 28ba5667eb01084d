# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes: a callback converts, calls the core and publishes; no mathematics here."""

from __future__ import annotations

import importlib.util

from aerial_gnss_ros.core.values.errors import RosError
from aerial_gnss_ros.resources import install_hint, ros_distribution


def require_ros() -> None:
    """Raise RosError, with a remedy, if ROS 2 or a message package is missing."""
    distribution = ros_distribution()
    if importlib.util.find_spec("rclpy") is None:
        raise RosError(
            f"ROS 2 is not found: on a robot source /opt/ros/{distribution}/setup.bash first, "
            f"elsewhere {install_hint('ros')}, then `pip install ./interfaces` there, as `make "
            "demo` does."
        )
    for package in ("vision_msgs", "geographic_msgs", "tf2_msgs"):
        if importlib.util.find_spec(package) is None:
            raise RosError(
                f"{package} is not found: on a robot install ros-{distribution}-"
                f"{package.replace('_', '-')}, elsewhere `pip install ./interfaces` after "
                f"{install_hint('ros')}."
            )
