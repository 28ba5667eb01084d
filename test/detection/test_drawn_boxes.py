# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes drawn on an image."""

from __future__ import annotations

import cv2
import numpy as np

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.detection.drawn_boxes import boxes_jpeg


def test_a_box_is_drawn_round_its_middle_with_its_class_and_score():
    image = np.full((120, 160, 3), 60, np.uint8)
    one = DetectionFrame(
        0, "camera", np.array([[80.0, 70.0]]), np.array([[60.0, 40.0]]), np.array([0.75]), ("aqua",)
    )
    picture = cv2.imdecode(np.frombuffer(boxes_jpeg(image, one), np.uint8), cv2.IMREAD_COLOR)
    changed = np.abs(picture.astype(int) - 60).sum(axis=2) > 150
    for u, v in ((50, 70), (110, 70), (80, 50), (80, 90)):  # middles of its sides
        assert changed[v - 2 : v + 3, u - 2 : u + 3].any()
    assert not changed[58:82, 58:102].any()  # inside
    assert changed[30:47, 45:].any()  # its name, above
    assert not changed[95:].any()
    assert (image == 60).all()
