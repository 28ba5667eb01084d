# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages from dicts, through CDR and back."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.bags.typestore import TEXTS, make, serialize, typestore


def round_trip(msgtype, fields):
    return typestore().deserialize_cdr(serialize(msgtype, fields), msgtype)


def test_every_message_text_is_registered():
    names = {f"{path.parent.parent.name}/msg/{path.stem}" for path in TEXTS.glob("*/msg/*.msg")}
    assert len(names) == 14
    assert names <= set(typestore().fielddefs)


def test_what_is_absent_gets_the_ros_default():
    pose = make("geographic_msgs/msg/GeoPoseWithCovarianceStamped", {})
    assert pose.pose.pose.orientation.w == 1.0
    assert pose.pose.pose.orientation.x == 0.0
    np.testing.assert_array_equal(pose.pose.covariance, np.zeros(36))
    assert make("vision_msgs/msg/Detection2DArray", {}).detections == []
    assert make("sensor_msgs/msg/Image", {}).data.dtype == np.uint8


def test_nested_lists_strings_arrays_and_bytes_survive_cdr():
    array = round_trip(
        "vision_msgs/msg/Detection2DArray",
        {
            "header": {"stamp": {"sec": 3, "nanosec": 7}, "frame_id": "camera"},
            "detections": [
                {
                    "results": [{"hypothesis": {"class_id": "aqua", "score": 0.75}}],
                    "bbox": {"center": {"position": {"x": 12.5, "y": 8.0}}, "size_x": 4.0},
                }
            ],
        },
    )
    [box] = array.detections
    assert (array.header.stamp.sec, array.header.stamp.nanosec) == (3, 7)
    assert box.results[0].hypothesis.class_id == "aqua"
    assert box.results[0].pose.pose.orientation.w == 1.0
    assert (box.bbox.center.position.x, box.bbox.size_x, box.bbox.size_y) == (12.5, 4.0, 0.0)
    image = round_trip("sensor_msgs/msg/CompressedImage", {"format": "jpeg", "data": b"\xff\xd8"})
    assert bytes(image.data) == b"\xff\xd8"
    info = round_trip("sensor_msgs/msg/CameraInfo", {"k": [1.0] * 9, "d": [0.1, 0.2]})
    np.testing.assert_array_equal(info.d, [0.1, 0.2])
