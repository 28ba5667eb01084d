# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A detector whose answer is known: every blob of bright pixels in what it is shown is a robot."""

from __future__ import annotations

import cv2
import numpy as np

from aerial_gnss_ros.detection.base import within_image

SEA, ROBOT = 20, 250


def sea(size, *boxes):
    """Return dark water (width, height) with a bright robot on each (left, top, width, height)."""
    image = np.full((size[1], size[0], 3), SEA, np.uint8)
    for left, top, width, height in boxes:
        low = (max(0, left), max(0, top))
        image[low[1] : max(0, top + height), low[0] : max(0, left + width)] = ROBOT
    return image


class BlobDetector:
    """Finds blobs, remembers the sizes of what it was shown, and can be made blind."""

    name, class_names = "blobs", ("aqua",)

    def __init__(self):
        self.shown = []
        self.blind = False

    def detect(self, image):
        height, width = image.shape[:2]
        self.shown.append((width, height))
        mask = np.zeros((height, width), np.uint8) if self.blind else np.uint8(image[:, :, 0] > 200)
        stats = cv2.connectedComponentsWithStats(mask)[2][1:, :4].astype(float)
        corners = np.hstack([stats[:, :2], stats[:, :2] + stats[:, 2:]])
        zeros = np.zeros(len(corners), np.int64)
        scores = np.full(len(corners), 0.9)
        stages = {"pre": 1.0, "infer": 2.0, "post": 0.5}
        return within_image(corners, scores, zeros, self.class_names, (width, height), stages)


def boxes(found):
    """Return what was found as sorted (left, top, width, height)."""
    return sorted(
        (round(left + 0.5), round(top + 0.5), round(right - left), round(bottom - top))
        for left, top, right, bottom in found.xyxy
    )
