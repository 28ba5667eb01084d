# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The code and YAML of docs/howto/consuming.md: it runs, and robot_localization knows its keys."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading

import pytest
import yaml

# robot_localization, branch ros2: params/ekf.yaml and src/ros_filter.cpp.
KEYS = {
    "frequency", "two_d_mode", "map_frame", "odom_frame", "base_link_frame", "world_frame",
    "publish_tf", "smooth_lagged_data", "history_length",
}  # fmt: skip
SENSOR_KEYS = {"config", "differential", "relative", "queue_size"}
STATE = 15
X_Y = [True, True] + [False] * 13


@pytest.fixture(scope="module")
def blocks(repository):
    """Return the page's fenced blocks by language."""
    text = (repository / "docs/howto/consuming.md").read_text(encoding="utf-8")
    found = {}
    for language, block in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        found.setdefault(language, []).append(block)
    return found


def test_robot_localization_gets_x_and_y_of_position_update_alone(blocks):
    [node] = yaml.safe_load(blocks["yaml"][0]).values()
    parameters = node["ros__parameters"]
    sensors = {"odom0", "imu0", "pose0"}
    for key, value in parameters.items():
        name, _, rest = key.partition("_")
        if name not in sensors:
            assert key in KEYS, key
        elif rest:
            assert rest in SENSOR_KEYS, key
        if rest == "config":
            assert len(value) == STATE
    assert parameters["pose0"] == "/robots/aqua_1/position_update"
    assert parameters["pose0_config"] == X_Y
    assert parameters["world_frame"] == parameters["map_frame"]


def test_the_ten_lines_get_the_position_that_was_latched_before(blocks):
    rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from sensor_msgs.msg import NavSatFix

    from aerial_gnss_ros.nodes import qos

    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("estimator", context=context)
    publisher = node.create_publisher(NavSatFix, "robots/aqua_1/fix", qos.latched())
    message = NavSatFix(latitude=13.5, longitude=-59.5)
    message.status.status = 0
    message.position_covariance[0] = 4.0
    publisher.publish(message)
    stop = threading.Event()
    done = subprocess.run(
        [sys.executable, "-c", blocks["python"][0]],
        env=os.environ, capture_output=True, text=True, timeout=60.0, check=False,
    )  # fmt: skip
    stop.set()
    node.destroy_node()
    rclpy.shutdown(context=context)
    assert done.stdout.split() == ["13.5", "-59.5", "2.0", "0"], done.stderr
