# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Decodes images to blue-green-red arrays: messages of rclpy and rosbags, and files.

An image's size is read from its header, or from the message, before memory is allocated for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.image_header import MAX_PIXELS, read_header, refuse_large


@dataclass(frozen=True)
class _Layout:
    """Memory layout of an encoding.

    Attributes:
        channels: bytes of a pixel in a row.
        convert: OpenCV's code to blue, green, red; None: no conversion needed.
        even: sides that must be even: "w", "h" or both.
        rows: rows of memory for two rows of the image.
    """

    channels: int
    convert: int | None
    even: str = ""
    rows: int = 2


_UYVY = _Layout(2, cv2.COLOR_YUV2BGR_UYVY, even="w")
_YUYV = _Layout(2, cv2.COLOR_YUV2BGR_YUY2, even="w")
_LAYOUTS = {
    "bgr8": _Layout(3, None),
    "rgb8": _Layout(3, cv2.COLOR_RGB2BGR),
    "mono8": _Layout(1, cv2.COLOR_GRAY2BGR),
    "bgra8": _Layout(4, cv2.COLOR_BGRA2BGR),
    "rgba8": _Layout(4, cv2.COLOR_RGBA2BGR),
    "nv12": _Layout(1, cv2.COLOR_YUV2BGR_NV12, even="wh", rows=3),
    "yuv422": _UYVY,  # ROS's yuv422
    "uyvy": _UYVY,
    "yuv422_yuy2": _YUYV,
    "yuyv": _YUYV,
}
_KNOWN = "bgr8, rgb8, mono8, bgra8, rgba8, nv12, yuv422 (UYVY) and yuv422_yuy2"
_REASONS: tuple[tuple[Callable[[str], bool], str], ...] = (
    (lambda e: "bayer" in e, "a raw Bayer pattern; let image_proc or the driver debayer it"),
    (
        lambda e: any(word in e for word in ("h264", "h265", "hevc", "av1")),
        "a video stream; let the driver or image_transport decode it",
    ),
    (
        lambda e: "16" in e or "32" in e or "64" in e,
        "more than 8 bits a channel; set the driver to 8 bits",
    ),
    (lambda e: e.startswith("8"), "does not state the order of colours; set the driver to bgr8"),
)


def decode(message: Any, max_pixels: int = MAX_PIXELS) -> Image:
    """Return the image of a sensor_msgs Image or CompressedImage.

    Args:
        message: any object with the attributes of one of the two; `data` is bytes-like.
        max_pixels: larger images are refused before they are decoded.

    Returns:
        (height, width, 3) blue, green, red; a read-only view of the message where it can be.

    Raises:
        InputError: unknown encoding, no pixels, too many pixels, or another number of bytes than
            the size needs.
    """
    if hasattr(message, "encoding"):
        return _decode_raw(message, max_pixels)
    return _decode_compressed(message, max_pixels)


def read_image(path: Path, max_pixels: int = MAX_PIXELS) -> Image:
    """Return an image file as (height, width, 3) blue, green, red, ignoring EXIF rotation.

    Raises:
        InputError: missing, not an image, damaged, or of more pixels than `max_pixels`.
    """
    if path.is_fifo():  # would be waited for
        raise InputError(f"cannot read {path}: it is a pipe.")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}.") from error
    try:
        return _decode_file(content, max_pixels)
    except InputError as error:
        raise InputError(f"the image {path} cannot be read: {error}") from error


def write_jpeg(path: Path, image: Image, quality: int) -> None:
    """Write an image; unlike cv2.imwrite, this raises if the disk is full.

    Raises:
        OSError: it cannot be written.
    """
    done, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise OSError(f"{path} could not be encoded")
    path.write_bytes(encoded.tobytes())


def _decode_file(content: bytes, max_pixels: int) -> Image:
    header = read_header(content)
    if header is None:
        raise InputError("it is empty, damaged or not an image.")
    refuse_large(header.width, header.height, max_pixels, "")
    return _decode_bytes(content, header.kind)


def _decode_raw(message: Any, max_pixels: int) -> Image:
    encoding = str(message.encoding)
    layout = _LAYOUTS.get(encoding.lower())
    if layout is None:
        raise InputError(f"images in encoding {encoding!r} are not supported: {_reason(encoding)}.")
    width, height, step = int(message.width), int(message.height), int(message.step)
    if width <= 0 or height <= 0:
        raise InputError(f"an image of {width} x {height} pixels is empty.")
    if (width % 2 and "w" in layout.even) or (height % 2 and "h" in layout.even):
        raise InputError(f"an image in {encoding} cannot be {width} x {height}: odd side.")
    refuse_large(width, height, max_pixels)
    row = width * layout.channels
    step = step or row  # some drivers omit it if rows are not padded
    if step < row:
        raise InputError(
            f"the image's step is {step} bytes, but a row of {width} pixels in {encoding} has "
            f"{row}."
        )
    rows = height * layout.rows // 2
    data = np.frombuffer(message.data, dtype=np.uint8)
    needed = step * (rows - 1) + row
    if data.size < needed:
        raise InputError(
            f"an image of {width} x {height} in {encoding} needs {needed} bytes, the message has "
            f"{data.size}: it was cut off."
        )
    if data.size > step * rows:
        raise InputError(
            f"an image of {width} x {height} in {encoding} with rows of {step} bytes has "
            f"{step * rows} bytes, the message has {data.size}: size, step or encoding is wrong."
        )
    # A view with the row's own stride; the last row may lack its padding, so no plain reshape.
    shape = (rows, width) if layout.channels == 1 else (rows, width, layout.channels)
    strides = (step, 1) if layout.channels == 1 else (step, layout.channels, 1)
    view = np.lib.stride_tricks.as_strided(data, shape, strides, writeable=False)
    if layout.convert is None:
        return view
    try:
        return np.asarray(cv2.cvtColor(view, layout.convert), dtype=np.uint8)
    except (cv2.error, MemoryError) as error:
        raise InputError(f"an image of {width} x {height} does not fit into memory.") from error


def _reason(encoding: str) -> str:
    for applies, reason in _REASONS:
        if applies(encoding.lower()):
            return reason
    return f"known are {_KNOWN}"


def _decode_compressed(message: Any, max_pixels: int) -> Image:
    named, data = str(message.format), np.frombuffer(message.data, dtype=np.uint8).tobytes()
    if not data:
        raise InputError(f"a compressed image ({named!r}) has no bytes.")
    if "compressedDepth" in named:
        raise InputError("compressedDepth is a depth image; the detector needs a colour image.")
    header = read_header(data, ("PNG", "JPEG"))
    if header is None:
        reason = _reason(named) if any(applies(named.lower()) for applies, _ in _REASONS) else ""
        reason = reason or "its bytes are neither JPEG nor PNG"
        raise InputError(f"a compressed image in format {named!r} is not supported: {reason}.")
    refuse_large(header.width, header.height, max_pixels)
    if header.kind == "PNG" and len(data) > 24 and data[24] > 8:
        raise InputError(
            f"a PNG image with {data[24]} bits a channel is not supported; set the driver to 8 "
            "bits."
        )
    if header.kind == "JPEG":
        _check_jpeg_end(data)
    return _decode_bytes(data, header.kind)


def _decode_bytes(content: bytes, kind: str) -> Image:
    if kind == "PNG":
        _check_png_chunks(content)
    data = np.frombuffer(content, dtype=np.uint8)
    # The camera model applies to the pixels as captured: EXIF must not rotate them.
    try:
        image = cv2.imdecode(data, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    except (cv2.error, MemoryError) as error:
        raise InputError(f"a {kind} image of {data.size} bytes cannot be decoded.") from error
    if image is None or image.size == 0:
        raise InputError(f"a {kind} image of {data.size} bytes is damaged or cut off.")
    return np.asarray(image, dtype=np.uint8)


def _check_jpeg_end(data: bytes) -> None:
    """Refuse a truncated JPEG: decoders silently fill the rest with grey.

    Neither marker can occur inside compressed data, where 0xff is followed by 0 or a restart.
    """
    if data.rfind(b"\xff\xd9") < data.rfind(b"\xff\xda"):
        raise InputError(f"a JPEG image of {len(data)} bytes was cut off: its end is missing.")


def _check_png_chunks(data: bytes) -> None:
    """Refuse a PNG whose chunks are longer than it is: the decoder allocates what they claim.

    After 8 bytes a PNG is chunks of length (4 bytes), type (4), contents and checksum (4); the last
    one is IEND (ISO/IEC 15948, 5.3).
    """
    place = 8
    while place + 12 <= len(data):
        length = int.from_bytes(data[place : place + 4], "big")
        if length > len(data) - place - 12:
            break
        if data[place + 4 : place + 8] == b"IEND":
            return
        place += 12 + length
    raise InputError(f"a PNG image of {len(data)} bytes is damaged or cut off.")
