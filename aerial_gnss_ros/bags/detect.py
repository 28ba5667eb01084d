# SPDX-License-Identifier: Apache-2.0
"""Finds robots in recorded images, as the detector node does in live ones."""

from __future__ import annotations

from typing import Any

from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import copied_header
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.images import decode

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"


class ImageDetector:
    """Turns images into arrays of boxes.

    If the first image cannot be used the others will fare no better, so that is an error. A later
    one that is damaged is counted and left out.

    Args:
        detector: finds the boxes.
        topic: of the images, for messages.

    Attributes:
        refused: images that gave nothing.
        first_refusal: why, for the first of them.
    """

    def __init__(self, detector: Detector, topic: str) -> None:
        self.refused = 0
        self.first_refusal = ""
        self._detector = detector
        self._topic = topic
        self._used = 0
        self._camera_size: tuple[int, int] | None = None

    def take_camera_info(self, msg: Any) -> None:
        """Remember the size that the camera's description has."""
        self._camera_size = (int(msg.width), int(msg.height))

    def detect(self, msg: Any) -> dict[str, Any] | None:
        """Return the fields of a Detection2DArray, or None when the image cannot be used.

        Raises:
            InputError: the first image cannot be decoded, or is not of the camera's size.
        """
        try:
            image = decode(msg)
            self._check_size(image.shape[1], image.shape[0])
        except InputError as error:
            sentence = f"{self._topic}: {error}"
            if not self._used:
                raise InputError(sentence) from error
            self.refused += 1
            self.first_refusal = self.first_refusal or sentence
            return None
        self._used += 1
        return detection_array(self._detector.detect(image), copied_header(msg.header))

    def _check_size(self, width: int, height: int) -> None:
        size = self._camera_size
        if size is not None and size != (width, height):
            raise InputError(
                f"images are {width} x {height}, but their CameraInfo describes a camera of "
                f"{size[0]} x {size[1]}; give the CameraInfo of this image size."
            )


def detections_message(fields: dict[str, Any]) -> Any:
    """Return the array as a message, as if it had been recorded."""
    return make(DETECTIONS_TYPE, fields)
