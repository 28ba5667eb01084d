# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""An image's size is known before a pixel is decoded, and too large a one costs no memory."""

from __future__ import annotations

import io
import struct
import subprocess
import sys
import zlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from PIL import Image as PillowImage

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.image_header import (
    MAX_PIXELS,
    ImageHeader,
    read_header,
    refuse_large,
)
from aerial_gnss_ros.detection.images import decode, read_image

WIDTH, HEIGHT = 57, 33


def png_of_zeros(width: int, height: int) -> bytes:
    """A PNG of one bit a pixel: of 30000 x 30000 pixels in 110 kB."""
    rows = zlib.compressobj()
    row = bytes(1 + (width + 7) // 8)
    data = b"".join(rows.compress(row * 100) for _ in range(height // 100)) + rows.flush()

    def chunk(kind: bytes, content: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + content))
        return struct.pack(">I", len(content)) + kind + content + check

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def encoded(form: str, **options: object) -> bytes:
    file = io.BytesIO()
    pixels = np.random.default_rng(1).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    PillowImage.fromarray(pixels).save(file, form, **options)
    return file.getvalue()


def with_thumbnail() -> bytes:
    """A JPEG whose EXIF holds another JPEG: its size is not the image's."""
    thumbnail = cv2.imencode(".jpg", np.zeros((9, 11, 3), np.uint8))[1].tobytes()
    segment = b"Exif\0\0" + thumbnail
    plain = encoded("JPEG")
    return plain[:2] + b"\xff\xe1" + struct.pack(">H", len(segment) + 2) + segment + plain[2:]


def _header_or_refusal(data: bytes) -> object:
    try:
        return read_header(data)
    except InputError:
        return "refused"


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("PNG", encoded("PNG")),
        ("JPEG", encoded("JPEG")),
        ("JPEG", encoded("JPEG", progressive=True)),
        ("JPEG", with_thumbnail()),
        ("JPEG", encoded("JPEG")[:2] + b"\xff\xff\xff" + encoded("JPEG")[3:]),  # fill bytes
        ("BMP", encoded("BMP")),
        ("WebP", encoded("WEBP")),
        ("WebP", encoded("WEBP", lossless=True)),
        ("WebP", encoded("WEBP", exif=b"Exif\0\0II*\0\x08\0\0\0\0\0\0\0\0\0")),
        ("TIFF", encoded("TIFF")),
        ("TIFF", encoded("TIFF", big_tiff=True)),
        ("GIF", encoded("GIF")),
    ],
)
def test_the_size_stands_in_the_header(kind, data):
    assert read_header(data) == ImageHeader(kind, WIDTH, HEIGHT)
    found = {_header_or_refusal(data[:length]) for length in range(len(data))}  # cut off anywhere
    assert found <= {None, "refused", ImageHeader(kind, WIDTH, HEIGHT)}


def test_other_bytes_have_no_header():
    assert read_header(b"") is None
    assert read_header(b"no image at all") is None
    assert read_header(encoded("BMP"), ("PNG", "JPEG")) is None


@pytest.mark.parametrize("rubbish", [b"\xff", b"\x00", b"\xff\x00", b"\xff\xe0\x00\x02"])
def test_megabytes_of_rubbish_for_a_header_end_soon(rubbish):
    with pytest.raises(InputError, match="size cannot be read"):
        read_header(b"\xff\xd8" + rubbish * (8_000_000 // len(rubbish)))


def test_the_limit_itself_is_allowed():
    refuse_large(100, 50, 5000)
    with pytest.raises(InputError, match=r"101 x 50 pixels is larger than 5000 .*image.max_pix"):
        refuse_large(101, 50, 5000)


def test_messages_larger_than_the_limit_are_refused_and_others_decoded():
    data = encoded("PNG")
    small = SimpleNamespace(format="png", data=data)
    assert decode(small, WIDTH * HEIGHT).shape == (HEIGHT, WIDTH, 3)
    with pytest.raises(InputError, match=r"57 x 33 pixels .* was not decoded; .*image.max_pixels"):
        decode(small, WIDTH * HEIGHT - 1)
    raw = SimpleNamespace(
        encoding="mono8", width=WIDTH, height=HEIGHT, step=WIDTH, data=bytes(WIDTH * HEIGHT)
    )
    assert decode(raw, WIDTH * HEIGHT).shape == (HEIGHT, WIDTH, 3)
    with pytest.raises(InputError, match="57 x 33 pixels"):
        decode(raw, WIDTH * HEIGHT - 1)


IN_ANOTHER_PROCESS = """
import resource, sys
from pathlib import Path
from types import SimpleNamespace
from aerial_gnss_ros.detection.images import decode, read_image
from aerial_gnss_ros.training import inspection
file = Path(sys.argv[1])
message = SimpleNamespace(format="png", data=file.read_bytes())
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for look in (lambda: decode(message), lambda: read_image(file),
             lambda: inspection._decode(message.data)):
    try:
        look()
    except Exception as error:
        print(type(error).__name__, error)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)
"""


def test_a_png_of_30000_x_30000_pixels_is_refused_without_the_memory_for_it(tmp_path):
    file = tmp_path / "bomb.png"
    file.write_bytes(png_of_zeros(30000, 30000))
    assert file.stat().st_size < 1_000_000
    done = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS, file],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    *sentences, grown_mb = done.stdout.splitlines()
    assert len(sentences) == 3
    for sentence in sentences:
        assert f"30000 x 30000 pixels is larger than {MAX_PIXELS} pixels" in sentence, sentence
        assert sentence.startswith("InputError")
    assert int(grown_mb) < 20  # 2,700 MB decoded


def test_files_that_are_no_image_are_refused(tmp_path):
    file = tmp_path / "image.png"
    for content, words in (
        (b"", "empty"),
        (b"text", "not an image"),
        (encoded("PNG")[:40], "damaged"),
    ):
        file.write_bytes(content)
        with pytest.raises(InputError, match=words) as caught:
            read_image(file)
        assert str(file) in str(caught.value)
    with pytest.raises(InputError, match="cannot read"):
        read_image(tmp_path / "absent.png")
    with pytest.raises(InputError, match="cannot read"):
        read_image(tmp_path)
