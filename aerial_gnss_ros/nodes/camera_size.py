# SPDX-License-Identifier: Apache-2.0
"""Whether images have the size that their CameraInfo describes."""

from __future__ import annotations

from typing import Any


class CameraSize:
    """Takes CameraInfo and judges images.

    Attributes:
        size: width and height of the camera as it is described, px; zeros where the description is
            of no use, None before the first.
    """

    def __init__(self) -> None:
        self.size: tuple[int, int] | None = None

    def take(self, info: Any) -> None:
        """Take a CameraInfo."""
        usable = info.width > 0 and info.height > 0 and info.k[0] > 0.0
        self.size = (int(info.width), int(info.height)) if usable else (0, 0)

    def refusal(self, width: int, height: int, topic: str) -> tuple[str, str] | None:
        """Return why an image cannot be used: a word to count it by and a sentence; else None.

        Args:
            width: of the image, px.
            height: of the image, px.
            topic: of the CameraInfo, for the sentence.
        """
        size = self.size
        if size is None or size == (width, height):
            return None
        if size == (0, 0):
            reason = "its size or focal length is 0: the camera is not calibrated"
            return "camera_info_zeros", f"images are refused, {topic} cannot be used: {reason}"
        sentence = (
            f"images of {width} x {height} are refused: {topic} describes a camera of {size[0]} x "
            f"{size[1]}; let the driver publish both in one size"
        )
        return "camera_info_size", sentence
