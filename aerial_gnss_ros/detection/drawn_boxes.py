# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws detected boxes into an image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

_COLOUR = (0, 200, 255)  # BGR: amber, visible on any sea
_JPEG_QUALITY = 88


def boxes_jpeg(image: NDArray[np.uint8], found: DetectionFrame) -> bytes:
    """Return `with_boxes` as a JPEG."""
    picture = with_boxes(image, found)
    _, encoded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    return bytes(encoded)


def with_boxes(image: NDArray[np.uint8], found: DetectionFrame) -> NDArray[np.uint8]:
    """Return an image with boxes, class names and scores drawn into it.

    Args:
        image: (h, w, 3) BGR; unchanged.
        found: the image's detections.
    """
    picture = image.copy()
    for center, size, score, name in zip(
        found.centers, found.sizes, found.scores, found.class_ids, strict=True
    ):
        low = tuple(int(v) for v in np.round(center - size / 2.0))
        high = tuple(int(v) for v in np.round(center + size / 2.0))
        cv2.rectangle(picture, low, high, _COLOUR, 2, cv2.LINE_AA)
        cv2.putText(
            picture, f"{name} {score:.2f}", (low[0], max(low[1] - 6, 12)),
            cv2.FONT_HERSHEY_SIMPLEX, 0.55, _COLOUR, 1, cv2.LINE_AA,
        )  # fmt: skip
    return picture
