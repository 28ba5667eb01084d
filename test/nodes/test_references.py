# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot that sends a fix of its own corrects what the estimator node publishes."""

from __future__ import annotations

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402

KIND = "sensor_msgs/msg/NavSatFix"
OFF_DEG = 9e-6
"""A metre north of where the drone's receiver has it."""


def test_a_reference_s_own_fix_moves_what_is_published(ros, hovering, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("references: {boat: {class: aqua, topic: boat/fix}}\n")
    node = ros.add(EstimatorNode(Given([path])))
    drone, got = hovering(), []
    sender = ros.node("boat").create_publisher(message_class(KIND), "/boat/fix", qos.sensor(20))
    ros.node("heard").create_subscription(
        message_class(KIND), "/robots/aqua_1/fix", got.append, qos.latched()
    )
    ros.spin_until(lambda: sender.get_subscription_count() == 1)
    for _ in range(8):
        header = drone.telemetry(drone.now_ns)
        fix = {"header": header, "latitude": 13.0 + OFF_DEG, "longitude": -59.0}
        fix |= {"position_covariance": [1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4]}
        fix["position_covariance_type"] = 2
        sender.publish(message(KIND, fix))
        drone.boxes(header)
        ros.spin(0.1)
    drone.telemetry(drone.now_ns)
    ros.spin_until(lambda: any(one.position_covariance[0] < 0.1**2 for one in got))
    surest = min(got, key=lambda one: one.position_covariance[0])
    assert surest.latitude == pytest.approx(13.0 + OFF_DEG, abs=1e-6)
    assert {source.name: source.topic for source in node.inputs}["reference_boat"] == "/boat/fix"
