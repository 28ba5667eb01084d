# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads a video frame by frame, with the memory of one frame."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.image_header import MAX_PIXELS, read_header, refuse_large

_PICTURE_START = 65536


@dataclass(frozen=True)
class Video:
    """A video file.

    Attributes:
        path: the file.
        width: of its frames, px.
        height: px.
        rate_hz: frame rate, Hz.
        count: number of frames stated by the file.
    """

    path: Path
    width: int
    height: int
    rate_hz: float
    count: int

    @property
    def duration_s(self) -> float:
        """Length, s."""
        return self.count / self.rate_hz

    def jpegs(self, every: int, quality: int) -> Iterator[tuple[float, bytes]]:
        """Yield time in s and JPEG of every n-th frame.

        A frame of H.264 or H.265 video is mostly a difference from others, so it must be
        re-encoded; at quality 95 that makes no difference to a detector.

        Raises:
            InputError: the video ends long before its stated length (damaged, or cut off).
        """
        options = [int(cv2.IMWRITE_JPEG_QUALITY), quality]
        for stamp, image in self.frames(every):
            encoded, data = cv2.imencode(".jpg", image, options)
            if encoded:
                yield stamp, data.tobytes()

    def frames(self, every: int = 1) -> Iterator[tuple[float, Image]]:
        """Yield time in s and pixels of every n-th frame.

        Raises:
            InputError: the video ends far before its own length (damaged, or cut off).
        """
        capture = _open(self.path)
        last, index, origin = -1.0, 0, 0.0
        try:
            while capture.grab():
                own = float(capture.get(cv2.CAP_PROP_POS_MSEC)) * 1e-3
                origin = (
                    own if index == 0 else origin
                )  # the first frame is at 0, whatever its stamp
                stamp = _time(own - origin, index / self.rate_hz, last, self.duration_s)
                if index % every == 0:
                    read, image = capture.retrieve()
                    if not read:
                        break
                    last = stamp
                    yield stamp, np.asarray(image, dtype=np.uint8)
                index += 1
        finally:
            capture.release()
        if index < 0.9 * self.count:
            raise InputError(
                f"{self.path} ends after {index} of {self.count} frames; it is damaged or cut "
                "off, copy it from the card again."
            )


def open_video(path: str | Path) -> Video:
    """Open a video and check it.

    Raises:
        InputError: no such file, or OpenCV cannot read it.
    """
    path = Path(path)
    if not path.is_file():
        wrong = "is a folder" if path.is_dir() else "does not exist"
        raise InputError(f"{path} {wrong}; give the video file.")
    _refuse_picture(path)
    capture = _open(path)
    try:
        width = int(capture.get(cv2.CAP_PROP_FRAME_WIDTH))
        height = int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
        rate = float(capture.get(cv2.CAP_PROP_FPS))
        count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    finally:
        capture.release()
    if not (width > 0 and height > 0 and math.isfinite(rate) and rate > 0.0 and count > 0):
        raise InputError(
            f"{path} has no usable video ({width}x{height}, {rate:g} frames a second, {count} "
            "frames); convert it to mp4 first."
        )
    refuse_large(width, height, MAX_PIXELS, "")
    return Video(path, width, height, rate, count)


def _open(path: Path) -> cv2.VideoCapture:
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # the error is reported once, below
    capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        raise InputError(
            f"OpenCV cannot read {path} as a video; copy it from the card again if it is cut off, "
            "else convert it to mp4 first."
        )
    return capture


def _refuse_picture(path: Path) -> None:
    """Refuse a still image: OpenCV would decode it as a video of one frame, whatever its size."""
    try:
        with path.open("rb") as file:
            start = file.read(_PICTURE_START)
        header = read_header(start)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}.") from error
    except InputError as error:
        raise InputError(f"{path} is not a video: {error}") from error
    if header is not None:
        raise InputError(f"{path} is a {header.kind} image, not a video; give the video file.")


def _time(own: float, counted: float, last: float, duration_s: float) -> float:
    """Return a frame's time, s: its own stamp if plausible, else from its number.

    Of a variable frame rate, as phones and screen recorders have, the number tells little: the
    file states the mean rate.
    """
    sensible = math.isfinite(own) and last < own <= 1.05 * duration_s + 0.5
    return own if sensible else max(counted, last + 1e-6)
