# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector's images with their boxes drawn, for RViz and Foxglove, made only while watched."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from rclpy.publisher import Publisher

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.detection.base import Detections, Image
from aerial_gnss_ros.detection.config import AnnotatedConfig
from aerial_gnss_ros.detection.drawn_boxes import boxes_jpeg
from aerial_gnss_ros.nodes.ros_messages import message

ANNOTATED_TYPE = "sensor_msgs/msg/CompressedImage"


class AnnotatedTopic:
    """Publisher of `annotated/compressed`.

    Args:
        publisher: of the topic.
        config: rate and size.
    """

    def __init__(self, publisher: Publisher, config: AnnotatedConfig) -> None:
        self._publisher = publisher
        self._config = config
        self._last_ns: int | None = None

    def show(self, image: Image, found: Detections, header: dict[str, Any], now_ns: int) -> None:
        """Publish an image if somebody subscribes and the last one is long enough ago.

        Args:
            image: (h, w, 3) BGR, unchanged.
            found: its boxes.
            header: of the image.
            now_ns: a clock that is never set, ns.
        """
        last_ns, pause_ns = self._last_ns, round(1e9 / self._config.rate_hz)
        if last_ns is not None and now_ns - last_ns < pause_ns:
            return
        if not self._publisher.get_subscription_count():
            return
        self._last_ns = now_ns
        data = boxes_jpeg(*reduced(image, found, self._config.width_px))
        fields = {"header": header, "format": "jpeg", "data": data}
        self._publisher.publish(message(ANNOTATED_TYPE, fields))


def reduced(image: Image, found: Detections, width_px: int) -> tuple[Image, DetectionFrame]:
    """Return an image of at most a width, and its boxes in it.

    Args:
        image: (h, w, 3).
        found: its boxes.
        width_px: larger images are reduced to it.
    """
    height, width = image.shape[:2]
    scale = min(1.0, width_px / width)
    if scale < 1.0:
        size = (width_px, max(1, round(height * scale)))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    centers = scale * (found.xywh[:, :2] + 0.5) - 0.5  # the first pixel's centre is (0, 0)
    return image, DetectionFrame(
        0, "", centers, scale * found.xywh[:, 2:], found.scores, found.names
    )
