# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Profiles on live topics: what the node says when a vehicle does not send what is expected."""

from __future__ import annotations

import importlib.util
from dataclasses import replace

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from rcl_interfaces.msg import Log  # noqa: E402
from rclpy.qos import QoSDurabilityPolicy, QoSProfile  # noqa: E402

from aerial_gnss_ros.adapters import kinds  # noqa: E402
from aerial_gnss_ros.adapters.vehicles import vehicle_file  # noqa: E402
from aerial_gnss_ros.core.values.errors import RosError  # noqa: E402
from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.diagnostics import ERROR, STALE  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402


def publisher(ros, topic, kind):
    return ros.node("gimbal_driver").create_publisher(message_class(kind), topic, qos.sensor(10))


@pytest.mark.parametrize(
    ("vehicle", "package", "remedy"),
    [
        ("px4_uxrce", "px4_msgs", "build px4_msgs of the firmware's release"),
        ("mavros_px4", "mavros_msgs", "install ros-jazzy-mavros-msgs (it comes with MAVROS)"),
    ],
)
@pytest.mark.usefixtures("ros")
def test_a_message_package_that_is_missing_is_named_with_where_to_get_it(vehicle, package, remedy):
    if importlib.util.find_spec(package) is not None:
        pytest.skip(f"{package} is installed here")
    with pytest.raises(RosError, match=f"message type {package}/msg/") as refusal:
        EstimatorNode(Given([vehicle_file(vehicle)]))
    assert remedy in str(refusal.value)


@pytest.mark.parametrize("vehicle", ["generic", "dji_psdk", "anafi", "ardupilot_dds"])
def test_profiles_of_standard_messages_need_no_other_package(ros, vehicle):
    ros.add(EstimatorNode(Given([vehicle_file(vehicle)])))


@pytest.fixture
def elsewhere():
    """Return a node of another participant: one alone holds a topic to one type."""
    context = rclpy.Context()
    context.init(args=[])
    node = rclpy.create_node("vehicle", context=context)
    yield node
    node.destroy_node()
    context.try_shutdown()


def test_diagnostics_say_what_a_vehicle_sends_wrong_or_not_at_all(ros, elsewhere):
    arrays, logged = [], []
    panel = ros.node("panel")
    panel.create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)
    log = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)  # said once
    panel.create_subscription(Log, "/rosout", logged.append, log)
    ros.add(EstimatorNode(Given([vehicle_file("anafi")])))
    gimbal = "geometry_msgs/msg/QuaternionStamped"
    wrong = publisher(ros, "anafi/gimbal/attitude", gimbal)
    elsewhere.create_publisher(  # Float32 is meant
        message_class("std_msgs/msg/Float64"), "anafi/drone/altitude_above_to", 10
    )
    ros.spin_until(wrong.get_subscription_count)
    lines = {}

    def is_said(name, words):
        for array in arrays:
            lines.update({s.name.removeprefix("estimator: "): s for s in array.status})
        return name in lines and words in lines[name].message

    said = "std_msgs/msg/Float64 is published there instead of std_msgs/msg/Float32"
    ros.spin_until(lambda: is_said("fix", "no fix for") and is_said("height", said))
    zero = message(gimbal, {"quaternion": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}})

    def is_sent_and_said():
        wrong.publish(zero)  # best effort: one alone may be lost
        return is_said("gimbal", "length 0")

    ros.spin_until(is_sent_and_said)
    assert lines["gimbal"].level == ERROR
    assert "its quaternion has length 0 instead of 1" in lines["gimbal"].message
    assert lines["fix"].level == STALE
    assert lines["fix"].message.startswith("no fix for 5 s on /anafi/drone/gps/location")
    ros.spin_until(lambda: any("A message on gimbal is of no use" in line.msg for line in logged))
    assert all(line.level >= Log.WARN for line in logged if "of no use" in line.msg)


def test_a_topic_with_a_version_in_its_name_is_found(ros, monkeypatch):
    # stands for px4_msgs, which pip does not have: any type can be declared versioned
    monkeypatch.setitem(kinds.HEIGHT, "float64", replace(kinds.HEIGHT["float64"], versioned=True))
    node = ros.add(EstimatorNode())
    sender = publisher(ros, "height_v2", "std_msgs/msg/Float64")
    ros.connect(sender)
    sender.publish(message("std_msgs/msg/Float64", {"data": 12.0}))
    (height,) = (source for source in node.inputs if source.name == "height")
    ros.spin_until(lambda: height.arrivals.count == 1)
    assert height.topic == "/height_v2"
    assert node._estimator.inputs["height"].count == 1
