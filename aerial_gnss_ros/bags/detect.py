# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects robots in recorded images as the detector node does in live ones."""

from __future__ import annotations

from collections import Counter
from typing import Any

from aerial_gnss_ros.adapters.camera_size import CameraSize
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import copied_header
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Detector, Image
from aerial_gnss_ros.detection.image_header import MAX_PIXELS

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
MOST_TOLD, LEAST_TRIED = 8, 5
_REMEDY = "give the camera of these images as parameters (camera.source: parameters)"


class ImageDetector:
    """Detects boxes in recorded images.

    A damaged image is counted and skipped. If none of the first `LEAST_TRIED` is usable, the others
    will not be either, which is an error.

    Args:
        detector: finds the boxes.
        topic: of the images, for messages.
        described: source of the camera's description, for messages.
        max_pixels: larger images are refused before they are decoded.

    Attributes:
        refused: number of refused images.
        refusals: counts by sentence, of the first `MOST_TOLD` different ones.
        camera_size: compares images with CameraInfo.
    """

    def __init__(
        self, detector: Detector, topic: str, described: str, max_pixels: int = MAX_PIXELS
    ) -> None:
        self.refused = 0
        self.refusals: Counter[str] = Counter()
        self._detector = detector
        self._topic = topic
        self._described = described
        self._max_pixels = max_pixels
        self._used = 0
        self.camera_size = CameraSize(_REMEDY)

    def detect(self, msg: Any) -> dict[str, Any] | None:
        """Return the fields of a Detection2DArray, or None if the image is refused.

        Raises:
            InputError: none of the first images could be decoded with the camera's size.
        """
        from aerial_gnss_ros.detection.images import decode  # OpenCV: not for recorded boxes

        try:
            image = decode(msg, self._max_pixels)
            self._check_size(image)
        except InputError as error:
            sentence = f"{self._topic}: {error}"
            self.refused += 1
            if sentence in self.refusals or len(self.refusals) < MOST_TOLD:
                self.refusals[sentence] += 1
            if self.refused >= LEAST_TRIED:
                self.check()
            return None
        self._used += 1
        return detection_array(self._detector.detect(image), copied_header(msg.header))

    def check(self) -> None:
        """Raise InputError with the first refusal if no image was usable."""
        if self.refused and not self._used:
            raise InputError(next(iter(self.refusals)))

    def _check_size(self, image: Image) -> None:
        refusal = self.camera_size.refusal(image.shape[1], image.shape[0], self._described)
        if refusal is not None:
            raise InputError(f"{refusal[1]}.")


def detections_message(fields: dict[str, Any]) -> Any:
    """Return the array as a recorded message."""
    return make(DETECTIONS_TYPE, fields)
