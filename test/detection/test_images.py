# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every encoding against OpenCV's own conversion, and what is refused."""

from __future__ import annotations

import array
import zlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.images import decode

WIDTH, HEIGHT = 48, 32


def picture() -> np.ndarray:
    """A smooth picture: chroma is halved in some encodings, so neighbours must be alike."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    return np.stack([5 * u, 7 * v, 255 - 4 * u], axis=2).astype(np.uint8)


def message(encoding: str, rows: np.ndarray, *, padding: int = 0, **other: object):
    """A sensor_msgs/Image whose rows carry `padding` bytes of rubbish."""
    rows = np.ascontiguousarray(rows).reshape(len(rows), -1)
    step = rows.shape[1] + padding
    padded = np.full((len(rows), step), 0xAB, np.uint8)
    padded[:, : rows.shape[1]] = rows
    fields = {"width": WIDTH, "height": HEIGHT, "step": step, "is_bigendian": 1}
    return SimpleNamespace(encoding=encoding, data=padded.tobytes(), **(fields | other))


def uyvy(bgr: np.ndarray, order: str) -> np.ndarray:
    yuv = cv2.cvtColor(bgr, cv2.COLOR_BGR2YUV)
    y, u, v = yuv[..., 0], yuv[:, ::2, 1], yuv[:, ::2, 2]
    parts = {"Y": y, "U": u, "V": v}
    packed = np.empty((HEIGHT, WIDTH * 2), np.uint8)
    lumas = iter((y[:, ::2], y[:, 1::2]))
    for place, letter in enumerate(order):
        packed[:, place::4] = next(lumas) if letter == "Y" else parts[letter]
    return packed


def nv12(bgr: np.ndarray) -> np.ndarray:
    planar = cv2.cvtColor(bgr, cv2.COLOR_BGR2YUV_I420)
    luma = planar[:HEIGHT]
    u, v = planar[HEIGHT:].reshape(2, -1)
    chroma = np.stack([u, v], axis=1).reshape(HEIGHT // 2, WIDTH)
    return np.vstack([luma, chroma])


@pytest.mark.parametrize("padding", [0, 6])
@pytest.mark.parametrize(
    ("encoding", "code"),
    [
        ("bgr8", None),
        ("rgb8", cv2.COLOR_BGR2RGB),
        ("bgra8", cv2.COLOR_BGR2BGRA),
        ("rgba8", cv2.COLOR_BGR2RGBA),
    ],
)
def test_colours_come_back_exactly(encoding, code, padding):
    bgr = picture()
    rows = bgr if code is None else cv2.cvtColor(bgr, code)
    np.testing.assert_array_equal(decode(message(encoding, rows, padding=padding)), bgr)


@pytest.mark.parametrize("padding", [0, 6])
def test_grey_becomes_three_equal_channels(padding):
    grey = picture()[..., 0]
    decoded = decode(message("mono8", grey, padding=padding))
    for channel in range(3):
        np.testing.assert_array_equal(decoded[..., channel], grey)


@pytest.mark.parametrize("padding", [0, 6])
@pytest.mark.parametrize(
    ("encoding", "make"),
    [
        ("nv12", nv12),
        ("yuv422", lambda bgr: uyvy(bgr, "UYVY")),
        ("yuv422_yuy2", lambda bgr: uyvy(bgr, "YUYV")),
    ],
)
def test_video_encodings_keep_colours(encoding, make, padding):
    # In grey, u and v are the same: the picture is coloured. Video range and full range differ by
    # up to 16 of 255, swapped colours by far more than 25.
    bgr = picture()
    decoded = decode(message(encoding, make(bgr), padding=padding))
    assert decoded.shape == (HEIGHT, WIDTH, 3)
    assert np.abs(decoded.astype(int) - bgr).mean() < 25
    swapped = np.abs(decoded[..., ::-1].astype(int) - bgr).mean()
    assert swapped > 50


def test_data_of_rclpy_and_of_rosbags_are_read_alike():
    sample = message("bgr8", picture())
    for data in (array.array("B", sample.data), np.frombuffer(sample.data, np.uint8)):
        sample.data = data
        np.testing.assert_array_equal(decode(sample), picture())


def test_last_row_may_lack_its_padding():
    sample = message("bgr8", picture(), padding=6)
    sample.data = sample.data[:-6]
    np.testing.assert_array_equal(decode(sample), picture())


@pytest.mark.parametrize("form", ["jpeg", "bgr8; jpeg compressed bgr8", "jpg"])
def test_jpeg(form):
    coded = cv2.imencode(".jpg", picture(), [cv2.IMWRITE_JPEG_QUALITY, 95])[1]
    decoded = decode(SimpleNamespace(format=form, data=coded.tobytes()))
    assert np.abs(decoded.astype(int) - picture()).mean() < 4


def test_png_is_exact_and_grey_png_has_three_channels():
    coded = cv2.imencode(".png", picture())[1].tobytes()
    np.testing.assert_array_equal(decode(SimpleNamespace(format="png", data=coded)), picture())
    grey = cv2.imencode(".png", picture()[..., 0])[1].tobytes()
    assert decode(SimpleNamespace(format="png", data=grey)).shape == (HEIGHT, WIDTH, 3)


@pytest.mark.parametrize(
    ("encoding", "words"),
    [
        ("mono16", "8 bits"),
        ("16UC1", "8 bits"),
        ("32FC1", "8 bits"),
        ("rgb16", "8 bits"),
        ("bayer_rggb8", "debayer"),
        ("bayer_rggb16", "debayer"),
        ("h264", "video stream"),
        ("8UC3", "order of colours"),
        ("teal9", "known are bgr8"),
    ],
)
def test_other_encodings_are_refused_by_name(encoding, words):
    with pytest.raises(InputError, match=words) as caught:
        decode(message(encoding, picture()))
    assert repr(encoding) in str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"width": 0}, "0 x 32"),
        ({"height": 0}, "48 x 0"),
        ({"data": b""}, "cut off"),
        ({"data": bytes(WIDTH * HEIGHT * 3 - 1)}, "4608 bytes, the message has 4607"),
        ({"step": 10}, "step is 10"),
        ({"height": HEIGHT + 1}, "cut off"),
        ({"height": HEIGHT - 1}, "has 4464 bytes, the message has 4608"),
        ({"data": bytes(WIDTH * HEIGHT * 3 + 1)}, "4608 bytes, the message has 4609"),
        ({"width": WIDTH - 1, "step": WIDTH * 3 - 1}, "size, step or encoding is wrong"),
        ({"encoding": "yuv422", "width": 47}, "odd"),
        ({"encoding": "nv12", "height": 31}, "odd"),
    ],
)
def test_broken_images_are_refused(change, words):
    sample = message("bgr8", picture())
    vars(sample).update(change)
    with pytest.raises(InputError, match=words):
        decode(sample)


def jpeg() -> bytes:
    return cv2.imencode(".jpg", picture())[1].tobytes()


@pytest.mark.parametrize(
    ("form", "data", "words"),
    [
        ("jpeg", b"", "no bytes"),
        ("jpeg", jpeg()[:-40], "cut off"),
        ("jpeg", jpeg()[: len(jpeg()) // 2], "cut off"),
        ("jpeg", b"\xff\xd8\xff\xd9", "damaged"),
        ("png", cv2.imencode(".png", picture())[1].tobytes()[:60], "damaged|decoded"),
        ("png", cv2.imencode(".png", picture().astype(np.uint16))[1].tobytes(), "16 bits"),
        ("h264", b"\x00\x00\x00\x01\x67", "video stream"),
        ("webp", b"RIFF....WEBP", "neither JPEG nor PNG"),
        ("32FC1; compressedDepth png", b"\x00" * 20, "depth"),
    ],
)
def test_broken_compressed_images_are_refused(form, data, words):
    with pytest.raises(InputError, match=words):
        decode(SimpleNamespace(format=form, data=data))


def test_jpeg_with_rubbish_behind_its_end_is_read():
    assert decode(SimpleNamespace(format="jpeg", data=jpeg() + bytes(64))).shape[:2] == (
        HEIGHT,
        WIDTH,
    )


@pytest.mark.parametrize("claimed", [0x6300_0923, 0xFFFF_FFFF, 0x7FFF_FFFF])
def test_a_png_chunk_that_claims_gigabytes_is_refused_before_it_is_decoded(claimed, monkeypatch):
    """The decoder allocates what a chunk says that it holds."""
    coded = bytearray(cv2.imencode(".png", picture())[1].tobytes())
    place = coded.index(b"IDAT") - 4
    coded[place : place + 4] = claimed.to_bytes(4, "big")
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    with pytest.raises(InputError, match=r"PNG image of .* damaged or cut off"):
        decode(SimpleNamespace(format="png", data=bytes(coded)))


def test_a_png_may_have_other_chunks_and_bytes_after_its_end():
    coded = cv2.imencode(".png", picture())[1].tobytes()
    end = coded.index(b"IEND") - 4
    text = b"tEXta\0b"
    chunk = len(text[4:]).to_bytes(4, "big") + text + zlib.crc32(text).to_bytes(4, "big")
    longer = coded[:end] + chunk + coded[end:] + b"more"
    np.testing.assert_array_equal(decode(SimpleNamespace(format="png", data=longer)), picture())
    with pytest.raises(InputError, match="cut off"):
        decode(SimpleNamespace(format="png", data=coded[:-6]))
