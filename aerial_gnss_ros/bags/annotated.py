# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes images with drawn boxes: one file each, or a video."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.drawn_boxes import with_boxes
from aerial_gnss_ros.detection.images import write_jpeg

if TYPE_CHECKING:
    from typing_extensions import Self

_QUALITY = 88


class AnnotatedPictures:
    """One JPEG per image; use as a context manager.

    Args:
        folder: of the files.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __enter__(self) -> Self:
        """Enter; nothing is opened."""
        return self

    def __exit__(self, *_: object) -> None:
        """Exit; nothing is closed."""

    def add(self, name: str, image: Image, found: DetectionFrame) -> None:
        """Write an image with its boxes: a.jpg of a.png, a.png.jpg if there is an a.jpg already.

        Raises:
            OSError: it cannot be written.
        """
        path = self._folder / Path(name).with_suffix(".jpg")
        if path.exists():
            path = path.with_name(f"{Path(name).name}.jpg")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_jpeg(path, with_boxes(image, found), _QUALITY)


class AnnotatedVideo:
    """A video of all images; use as a context manager.

    Args:
        path: the file, .mp4.
        rate_hz: frame rate, Hz.
    """

    def __init__(self, path: Path, rate_hz: float) -> None:
        self._path, self._rate_hz = path, rate_hz
        self._writer: cv2.VideoWriter | None = None

    def __enter__(self) -> Self:
        """Enter; the video is created with the size of the first image."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the video."""
        if self._writer is not None:
            self._writer.release()

    def add(self, _name: str, image: Image, found: DetectionFrame) -> None:
        """Write a frame with its boxes.

        Raises:
            OutputError: the video cannot be written.
        """
        if self._writer is None:
            code = cv2.VideoWriter.fourcc(*"mp4v")
            size = (image.shape[1], image.shape[0])
            self._writer = cv2.VideoWriter(str(self._path), code, self._rate_hz, size)
            if not self._writer.isOpened():
                raise OutputError(
                    f"{self._path.name} cannot be written; leave annotated pictures out with "
                    "--no-pictures."
                )
        self._writer.write(with_boxes(image, found))
