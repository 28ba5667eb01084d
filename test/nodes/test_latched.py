# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is sent once and latched arrives, whenever it was sent, and once."""

from __future__ import annotations

import numpy as np
import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from std_msgs.msg import Float64  # noqa: E402

from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.latched import LatchedToo, Once  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402


def test_a_message_and_its_copy_are_one_in_either_order():
    once = Once()
    assert once.latched(5)
    assert not once.directly(5)
    assert once.directly(6)
    assert not once.latched(6)


def test_history_does_not_replace_what_is_newer():
    once = Once()
    assert once.directly(7)
    assert not once.latched(6)
    assert once.directly(6)  # of another publisher, whose clock lags
    assert once.latched(8)


@pytest.mark.parametrize("profile", [qos.sensor(10), qos.latched()], ids=["volatile", "latched"])
def test_each_publisher_is_heard_once(ros, profile):
    """The publisher comes first and sends before anybody listens, and goes on afterwards."""
    publisher = ros.node("sender").create_publisher(Float64, "level", profile)
    publisher.publish(Float64(data=1.0))
    node, got = ros.node("receiver"), []
    latched = LatchedToo(node)
    heard = latched.watch("level", "level", Float64, 10, lambda msg: got.append(msg.data))
    node.create_subscription(Float64, "level", heard, qos.sensor(10))
    node.create_timer(0.05, latched.look)
    kept = profile.durability == qos.latched().durability
    ros.connect(publisher)
    ros.spin_until(lambda: publisher.get_subscription_count() == (2 if kept else 1))
    ros.spin_until(lambda: got == [1.0] or not kept)
    for value in (2.0, 3.0):
        publisher.publish(Float64(data=value))
    ros.spin_until(lambda: got and got[-1] == 3.0)
    ros.spin(0.3)  # for a copy of the last
    assert got == ([1.0, 2.0, 3.0] if kept else [2.0, 3.0])


def test_camera_and_water_level_sent_once_before_our_start_are_used(ros, hovering, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("height: {reference: home}\n")
    sender = ros.node("boat")
    info, level = "sensor_msgs/msg/CameraInfo", "std_msgs/msg/Float64"
    k = [500.0, 0.0, 320.0, 0.0, 500.0, 180.0, 0.0, 0.0, 1.0]
    stamp = {"sec": sender.get_clock().now().nanoseconds // 10**9 - 60}
    fields = {"width": 640, "height": 360, "k": k, "d": [0.0] * 5, "header": {"stamp": stamp}}
    latched = {
        "camera/camera_info": (info, fields | {"distortion_model": "plumb_bob"}),
        "water_level": (level, {"data": -2.0}),
    }
    kept = []
    for topic, (kind, values) in latched.items():
        kept.append(sender.create_publisher(message_class(kind), topic, qos.latched()))
        kept[-1].publish(message(kind, values))
    node = ros.add(EstimatorNode(Given([path])))
    counts = {source.name: source.arrivals for source in node.inputs}
    ros.spin_until(lambda: counts["camera_info"].count and counts["water_level"].count)
    drone = hovering()
    send = drone.send
    drone.send = lambda topic, **more: topic in latched or send(topic, **more)
    for _ in range(6):
        drone.boxes(drone.telemetry(drone.now_ns), at=((420.0, 180.0),))
        ros.spin(0.1)
    drone.telemetry(drone.now_ns)
    ros.spin_until(lambda: node._images == 6)
    assert (counts["camera_info"].count, counts["water_level"].count) == (1, 1)
    (robot,) = node._departures.present
    # The camera is 12 m above the water, 10 m above home: 100 px are 2.4 m, not 2.0 m.
    assert float(np.hypot(*robot.position)) == pytest.approx(2.4, abs=0.05)


def test_the_camera_s_orientation_may_come_from_tf_with_a_static_part_sent_before(
    ros, hovering, tmp_path
):
    path = tmp_path / "p.yaml"
    frames = "base_frame: odom, camera_frame: lens_optical_frame"
    path.write_text(f"gimbal: {{source: tf, reference: earth, {frames}}}\n")
    kind = message_class("tf2_msgs/msg/TFMessage")
    sender = ros.node("robot_state")
    static = sender.create_publisher(kind, "/tf_static", qos.latched())
    moving = sender.create_publisher(kind, "/tf", qos.transforms())

    def transform(parent, child, rotation, stamp):
        link = {"header": {"stamp": stamp, "frame_id": parent}, "child_frame_id": child}
        link["transform"] = {"rotation": rotation}
        return message("tf2_msgs/msg/TFMessage", {"transforms": [link]})

    half = 0.5**0.5
    optical = {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}
    static.publish(transform("gimbal", "lens_optical_frame", optical, {"sec": 0, "nanosec": 0}))
    node = ros.add(EstimatorNode(Given([path])))
    drone = hovering("", 0, ("gimbal",))
    ros.spin_until(lambda: moving.get_subscription_count() == 1)
    for _ in range(8):
        header = drone.telemetry(drone.now_ns)
        down = {"x": 0.0, "y": half, "z": 0.0, "w": half}
        moving.publish(transform("odom", "gimbal", down, header["stamp"]))
        drone.boxes(header, at=((320.0, 80.0),))
        ros.spin(0.1)
    ros.spin_until(lambda: node._departures.present)
    (robot,) = node._departures.present
    assert list(robot.position) == pytest.approx([2.0, 0.0], abs=0.02)  # 100 px ahead, from 10 m
