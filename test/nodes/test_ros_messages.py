# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results become the same bytes through rclpy and through rosbags."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.bags.typestore import make, typestore
from aerial_gnss_ros.core.values.errors import RosError

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from rclpy.serialization import serialize_message

from aerial_gnss_ros.nodes.ros_messages import message, message_class

HEADER = {"stamp": {"sec": 5, "nanosec": 6}, "frame_id": "map"}


@pytest.mark.parametrize(
    ("msgtype", "fields"),
    [
        (
            "sensor_msgs/msg/NavSatFix",
            {"header": HEADER, "status": {"status": -1}, "latitude": 1.5,
             "position_covariance": [float(i) for i in range(9)]},
        ),
        (
            "geographic_msgs/msg/GeoPoseWithCovarianceStamped",
            {"header": HEADER, "pose": {"pose": {"position": {"altitude": float("nan")},
                                                 "orientation": {"z": 0.6, "w": 0.8}},
                                        "covariance": [0.5] * 36}},
        ),
        (
            "vision_msgs/msg/Detection2DArray",
            {"header": HEADER, "detections": [
                {"results": [{"hypothesis": {"class_id": "aqua", "score": 0.5}}],
                 "bbox": {"center": {"position": {"x": 1.0, "y": 2.0}}, "size_x": 3.0}},
                {"id": "7"},
            ]},
        ),
        ("sensor_msgs/msg/CameraInfo", {"width": 5, "d": [1.0, 2.0], "k": [3.0] * 9}),
        ("visualization_msgs/msg/MarkerArray", {"markers": [{"ns": "aqua_1", "points": []}]}),
    ],
)  # fmt: skip
def test_a_dict_becomes_the_same_message_on_both_sides(msgtype, fields):
    ours = serialize_message(message(msgtype, fields))
    # rosbags pads differently, so both are compared as what rosbags reads from them
    store = typestore()
    theirs = store.serialize_cdr(make(msgtype, fields), msgtype)
    assert repr(store.deserialize_cdr(ours, msgtype)) == repr(
        store.deserialize_cdr(theirs, msgtype)
    )


def test_unknown_types_and_fields_are_refused():
    with pytest.raises(RosError, match="ros-jazzy-mavros-msgs"):
        message_class("mavros_msgs/msg/Altitude")
    with pytest.raises(RosError, match="sensor_msgs/msg/NoSuchThing is not installed"):
        message_class("sensor_msgs/msg/NoSuchThing")
    with pytest.raises(AttributeError):
        message("std_msgs/msg/Float64", {"value": 1.0})
