# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images with drawn boxes: while somebody subscribes, not too often, not too large."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import AnnotatedConfig

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.nodes.annotated import AnnotatedTopic, reduced

SECOND = 10**9
HEADER = header_fields(5 * SECOND, "camera")
BLUE = np.full((180, 320, 3), (120, 60, 20), np.uint8)
ONE = Detections(np.array([[159.5, 89.5, 80.0, 40.0]]), np.array([0.9]), np.array([0]), ("aqua",))


class Publisher:
    """Counts what is published."""

    def __init__(self, subscribers=1):
        self.subscribers, self.sent = subscribers, []

    def get_subscription_count(self):
        return self.subscribers

    def publish(self, msg):
        self.sent.append(msg)


def decoded(msg):
    return cv2.imdecode(np.frombuffer(bytes(msg.data), np.uint8), cv2.IMREAD_COLOR)


def test_nothing_is_made_for_nobody_and_no_more_than_asked_for():
    publisher = Publisher(subscribers=0)
    topic = AnnotatedTopic(publisher, AnnotatedConfig(rate_hz=4.0))
    topic.show(BLUE, ONE, HEADER, 0)
    assert not publisher.sent
    publisher.subscribers = 1
    for i in range(31):  # 10 Hz for 3 s
        topic.show(BLUE, ONE, HEADER, SECOND + i * SECOND // 10)
    assert len(publisher.sent) == 11  # every third: 0.25 s apart at least


def test_the_box_is_drawn_where_it_is_also_in_a_reduced_image():
    publisher = Publisher()
    before = BLUE.copy()
    for width, scale in ((320, 1.0), (160, 0.5), (1000, 1.0)):
        AnnotatedTopic(publisher, AnnotatedConfig(width_px=width)).show(BLUE, ONE, HEADER, 0)
        msg = publisher.sent[-1]
        assert (msg.format, msg.header.stamp.sec, msg.header.frame_id) == ("jpeg", 5, "camera")
        picture = decoded(msg)
        assert picture.shape[:2] == (round(180 * scale), round(320 * scale))
        drawn = picture[:, :, 2] > 150
        column = np.flatnonzero(drawn[round(90 * scale)])
        assert column.min() == pytest.approx(119.5 * scale, abs=2.5)
        assert column.max() == pytest.approx(199.5 * scale, abs=2.5)
        row = np.flatnonzero(drawn[:, round(190 * scale)])
        assert row.max() == pytest.approx(109.5 * scale, abs=2.5)
    assert np.array_equal(before, BLUE)


def test_an_image_without_boxes_is_shown_as_it_is():
    none = Detections(np.zeros((0, 4)), np.zeros(0), np.zeros(0, np.int64), ("aqua",))
    image, frame = reduced(BLUE, none, 320)
    assert image is BLUE
    assert len(frame) == 0
