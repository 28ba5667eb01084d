# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of a bag become boxes, and those that cannot are counted."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.detect import LEAST_TRIED, MOST_TOLD, ImageDetector, detections_message
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Detections


class Seeing:
    """A detector that finds one box in the middle."""

    name, class_names = "seeing", ("aqua",)

    def detect(self, image):
        height, width = image.shape[:2]
        box = np.array([[width / 2, height / 2, 4.0, 2.0]])
        return Detections(box, np.array([0.75]), np.array([0]), self.class_names)


def image(width=8, height=6, data=None):
    data = np.zeros(3 * width * height if data is None else data, np.uint8)
    return make(
        "sensor_msgs/msg/Image",
        {"header": header_fields(7, "camera"), "width": width, "height": height,
         "encoding": "bgr8", "step": 3 * width, "data": data},
    )  # fmt: skip


def detector():
    return ImageDetector(Seeing(), "/image", "/camera_info")


def test_boxes_carry_the_images_header():
    fields = detector().detect(image())
    message = detections_message(fields)
    assert (message.header.stamp.nanosec, message.header.frame_id) == (7, "camera")
    (box,) = message.detections
    assert (box.bbox.center.position.x, box.bbox.size_x) == (4.0, 4.0)
    assert box.results[0].hypothesis.score == 0.75


def test_an_image_that_cannot_be_used_is_counted_by_its_sentence():
    found = detector()
    assert found.detect(image()) is not None
    for _ in range(2):
        assert found.detect(image(data=5)) is None
    for width in range(20, 20 + 2 * MOST_TOLD):
        found.detect(image(width, data=5))
    assert found.refused == 2 + 2 * MOST_TOLD
    assert len(found.refusals) <= MOST_TOLD
    assert all(one.startswith("/image: ") for one in found.refusals)
    found.check()


def test_where_none_of_the_first_images_can_be_used_it_ends():
    found = detector()
    for _ in range(LEAST_TRIED - 1):
        assert found.detect(image(data=5)) is None
    with pytest.raises(InputError, match="/image: "):
        found.detect(image(data=5))
    with pytest.raises(InputError, match="/image: "):
        found.check()


def test_images_of_another_size_than_the_camera_are_refused():
    found = detector()
    info = make("sensor_msgs/msg/CameraInfo", {"width": 8, "height": 5, "k": [9.0] + 8 * [0.0]})
    found.camera_size.update(info)
    assert found.detect(image()) is None
    (sentence,) = found.refusals
    assert "8 x 6" in sentence
    assert "/camera_info" in sentence
