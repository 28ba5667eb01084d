# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Format and size of an encoded image from its header, without decoding a pixel.

A PNG of a few hundred kilobytes may unpack to gigabytes, so the size is read first. Only formats
read here are given to a decoder.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from aerial_gnss_ros.core.values.errors import InputError

MAX_PIXELS = 175_000_000
"""More than any drone's camera has (151 megapixels in 2026); decoded, that is 525 MB."""

HIGHEST_MAX_PIXELS = 1_000_000_000
"""OpenCV itself refuses more than 2 ** 30."""

_PNG = b"\x89PNG\r\n\x1a\n"
# Start of frame, ITU-T T.81 table B.1; C4 (Huffman tables), C8 and CC are something else.
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JPEG_WITHOUT_LENGTH = frozenset({0x01, *range(0xD0, 0xD9)})
_JPEG_SCAN, _JPEG_END = 0xDA, 0xD9
_JPEG_MARKER = re.compile(rb"\xff([^\x00\xff])", re.DOTALL)
_JPEG_MOST_SEGMENTS = 4096
_TIFF_WIDTH, _TIFF_HEIGHT = 256, 257
_TIFF_NUMBERS = {1: "B", 3: "H", 4: "I", 16: "Q"}


@dataclass(frozen=True)
class ImageHeader:
    """Format and size of an encoded image.

    Attributes:
        kind: PNG, JPEG, BMP, WebP, TIFF or GIF.
        width: px.
        height: px.
    """

    kind: str
    width: int
    height: int


def read_header(data: bytes, kinds: Sequence[str] = ()) -> ImageHeader | None:
    """Return format and size of an encoded image; None for an unknown format.

    Args:
        data: the image, or its beginning as far as the header reaches.
        kinds: accepted formats; empty: all.

    Raises:
        InputError: the format is known, but the header is damaged or cut off.
    """
    for kind, known, size in _FORMATS:
        if known(data[:16]) and (not kinds or kind in kinds):
            try:
                width, height = size(data)
            except (struct.error, IndexError, KeyError, ValueError) as error:
                raise InputError(
                    f"a {kind} image of {len(data)} bytes is damaged or cut off: its size cannot "
                    "be read."
                ) from error
            return ImageHeader(kind, width, height)
    return None


def refuse_large(width: int, height: int, max_pixels: int, name: str = "image.max_pixels") -> None:
    """Refuse an image before memory is allocated for it.

    Args:
        width: px.
        height: px.
        max_pixels: greatest number of pixels to decode.
        name: the parameter that sets it; empty without one.

    Raises:
        InputError: it has more pixels.
    """
    if width * height > max_pixels:
        remedy = f"if your camera has this size, raise {name}" if name else "make it smaller"
        raise InputError(
            f"an image of {width} x {height} pixels is larger than {max_pixels} pixels and was not "
            f"decoded; {remedy}."
        )


def _png(data: bytes) -> tuple[int, int]:
    if data[12:16] != b"IHDR":
        raise ValueError("no IHDR")
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def _jpeg(data: bytes) -> tuple[int, int]:
    """Walk the segments to the first frame, as libjpeg does: bytes between them are skipped."""
    place = 2
    for _ in range(_JPEG_MOST_SEGMENTS):
        match = _JPEG_MARKER.search(data, place)
        if match is None:
            break
        marker, place = match[1][0], match.end()
        if marker in _JPEG_FRAMES:
            height, width = struct.unpack(">HH", data[place + 3 : place + 7])
            return width, height
        if marker in (_JPEG_SCAN, _JPEG_END):
            break
        if marker not in _JPEG_WITHOUT_LENGTH:
            (length,) = struct.unpack(">H", data[place : place + 2])
            place += max(int(length), 2)
    raise ValueError("no frame")


def _bmp(data: bytes) -> tuple[int, int]:
    (header,) = struct.unpack("<I", data[14:18])
    form = "<HH" if header == 12 else "<ii"
    width, height = struct.unpack(form, data[18 : 18 + struct.calcsize(form)])
    return abs(width), abs(height)  # a negative height: the top row comes first


def _webp(data: bytes) -> tuple[int, int]:
    chunk = data[12:16]
    if chunk == b"VP8X" and len(data) >= 30:
        return 1 + int.from_bytes(data[24:27], "little"), 1 + int.from_bytes(data[27:30], "little")
    if chunk == b"VP8L":
        (bits,) = struct.unpack("<I", data[21:25])
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    if chunk == b"VP8 ":
        width, height = struct.unpack("<HH", data[26:30])
        return width & 0x3FFF, height & 0x3FFF
    raise ValueError("unknown chunk")


def _tiff(data: bytes) -> tuple[int, int]:
    """Return the size in the first directory; BigTIFF too."""
    order = "<" if data[:2] == b"II" else ">"
    (version,) = struct.unpack(f"{order}H", data[2:4])
    big = version == 43
    start_form, count_form, entry, inline = ("Q", "Q", 20, 12) if big else ("I", "H", 12, 8)
    start_at = 8 if big else 4
    start = _number(data, start_at, order + start_form)
    count = _number(data, start, order + count_form)
    place = start + struct.calcsize(count_form)
    found: dict[int, int] = {}
    for at in range(place, place + min(count, 4096) * entry, entry):
        tag, kind = struct.unpack(f"{order}HH", data[at : at + 4])
        if tag in (_TIFF_WIDTH, _TIFF_HEIGHT):
            found[tag] = _number(data, at + inline, order + _TIFF_NUMBERS[kind])
    return found[_TIFF_WIDTH], found[_TIFF_HEIGHT]


def _number(data: bytes, place: int, form: str) -> int:
    (number,) = struct.unpack(form, data[place : place + struct.calcsize(form)])
    return int(number)


def _gif(data: bytes) -> tuple[int, int]:
    width, height = struct.unpack("<HH", data[6:10])
    return width, height


_Size = Callable[[bytes], tuple[int, int]]
_FORMATS: tuple[tuple[str, Callable[[bytes], bool], _Size], ...] = (
    ("PNG", lambda head: head.startswith(_PNG), _png),
    ("JPEG", lambda head: head.startswith(b"\xff\xd8"), _jpeg),
    ("BMP", lambda head: head.startswith(b"BM"), _bmp),
    ("WebP", lambda head: head.startswith(b"RIFF") and head[8:12] == b"WEBP", _webp),
    ("TIFF", lambda head: head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"), _tiff),
    ("GIF", lambda head: head.startswith((b"GIF87a", b"GIF89a")), _gif),
)
