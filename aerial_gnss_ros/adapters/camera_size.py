# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compares the size of images with their CameraInfo, live and in bags."""

from __future__ import annotations

from typing import Any


class CameraSize:
    """Compares images with the newest CameraInfo.

    Args:
        remedy: advice for different sizes, as part of the sentence.

    Attributes:
        size: width and height in the camera's description, px; zeros if it is unusable, None before
            the first.
    """

    def __init__(self, remedy: str) -> None:
        self.size: tuple[int, int] | None = None
        self._remedy = remedy

    def update(self, info: Any) -> None:
        """Take a CameraInfo of ROS 2 (`k`) or of ROS 1 (`K`)."""
        matrix = info.k if hasattr(info, "k") else info.K
        usable = info.width > 0 and info.height > 0 and matrix[0] > 0.0
        self.size = (int(info.width), int(info.height)) if usable else (0, 0)

    def refusal(self, width: int, height: int, described: str) -> tuple[str, str] | None:
        """Return why an image is refused, as an identifier and a sentence; None if it is not.

        Args:
            width: of the image, px.
            height: of the image, px.
            described: source of the description, such as the topic of the CameraInfo.
        """
        size = self.size
        if size is None or size == (width, height):
            return None
        if size == (0, 0):
            reason = "its size or focal length is 0: the camera is not calibrated"
            return "camera_info_zeros", (
                f"images are refused because {described} is unusable: {reason}"
            )
        sentence = (
            f"images of {width} x {height} are refused: {described} describes a camera of "
            f"{size[0]} x {size[1]}; {self._remedy}"
        )
        return "camera_info_size", sentence
