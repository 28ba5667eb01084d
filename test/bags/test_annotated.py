# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes are drawn where they are, in files and in a video."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.bags.annotated import AnnotatedPictures, AnnotatedVideo
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import OutputError

SEA = np.full((120, 160, 3), 60, dtype=np.uint8)
FOUND = DetectionFrame(
    0, "", np.array([[80.0, 70.0]]), np.array([[120.0, 20.0]]), np.array([0.9]), ("aqua",)
)


def drawn(picture):
    """Return the rows and columns of a box's edges, right of its label and in its middle."""
    bright = picture[:, :, 2] > 150
    return np.flatnonzero(bright[:, 135]), np.flatnonzero(bright[70])


def test_a_file_for_each_picture(tmp_path):
    with AnnotatedPictures(tmp_path) as sink:
        sink.add("north/a.png", SEA, FOUND)
    rows, columns = drawn(cv2.imread(str(tmp_path / "north" / "a.jpg")))
    assert (rows.min(), rows.max()) == pytest.approx((60, 80), abs=2)
    assert (columns.min(), columns.max()) == pytest.approx((20, 140), abs=2)
    assert (SEA == 60).all()


def test_pictures_that_differ_in_their_ending_have_a_file_each(tmp_path):
    with AnnotatedPictures(tmp_path) as sink:
        for name in ("a.jpg", "a.png", "b.png"):
            sink.add(name, SEA, FOUND)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.jpg", "a.png.jpg", "b.jpg"]


def test_a_video_of_all(tmp_path):
    path = tmp_path / "a.mp4"
    try:
        with AnnotatedVideo(path, 5.0) as sink:
            for _ in range(3):
                sink.add("", SEA, FOUND)
    except OutputError:
        pytest.skip("this OpenCV has no encoder for mp4v")
    capture = cv2.VideoCapture(str(path))
    assert (capture.get(cv2.CAP_PROP_FRAME_COUNT), capture.get(cv2.CAP_PROP_FPS)) == (3, 5.0)
    _, frame = capture.read()
    _, columns = drawn(frame)
    assert (columns.min(), columns.max()) == pytest.approx((20, 140), abs=3)


def test_a_video_that_cannot_be_written_is_reported(tmp_path):
    with (
        pytest.raises(OutputError, match="--no-pictures"),
        AnnotatedVideo(tmp_path / "nowhere" / "a.mp4", 5.0) as sink,
    ):
        sink.add("", SEA, FOUND)
