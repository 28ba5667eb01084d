# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""/tf and /tf_static as a viewer receives them, and their switches."""

from __future__ import annotations

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("tf2_msgs", reason="no tf2_msgs: install interfaces/")

from tf2_msgs.msg import TFMessage  # noqa: E402

from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402


def test_a_viewer_gets_both_transforms_in_the_namespace_s_frames(ros, hovering):
    node = ros.add(EstimatorNode(Given(namespace="drone1")))
    moving, static = [], []
    viewer = ros.node("viewer")
    viewer.create_subscription(TFMessage, "/tf", moving.append, qos.transforms())
    last_ns = hovering("drone1").fly()
    ros.spin_until(lambda: node._images == 6 and moving)
    viewer.create_subscription(TFMessage, "/tf_static", static.append, qos.latched())  # late
    ros.spin_until(lambda: static)
    (earth,) = static[0].transforms
    assert (earth.header.frame_id, earth.child_frame_id) == ("earth", "drone1/map")
    x, y = earth.transform.translation.x, earth.transform.translation.y
    assert y / x == pytest.approx(-1.6642795, abs=1e-6)  # tan(-59 deg)
    (robot,) = moving[-1].transforms
    assert (robot.header.frame_id, robot.child_frame_id) == ("drone1/map", "drone1/aqua_1/course")
    assert robot.header.stamp.sec * 10**9 + robot.header.stamp.nanosec <= last_ns
    assert robot.transform.translation.z == 0.0
    assert abs(robot.transform.translation.x) < 0.1


def test_transforms_can_be_switched_off(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("map: {publish_tf: false, publish_earth_tf: false}\n")
    node = ros.add(EstimatorNode(Given([path])))
    ours = [name for name, _ in node.get_publisher_names_and_types_by_node("estimator", "/")]
    assert not {"/tf", "/tf_static"} & set(ours)
