# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detections refuse what is no detection, and boxes stay within the image."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections, within_image

GOOD = {
    "xywh": np.array([[10.0, 20.0, 4.0, 2.0]]),
    "scores": np.array([0.5]),
    "class_ids": np.array([0]),
    "class_names": ("aqua",),
}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"xywh": np.zeros((1, 3))}, r"shape \(1, 4\), got \(1, 3\)"),
        ({"scores": np.array([1.5])}, "0 to 1"),
        ({"scores": np.array([np.nan])}, "0 to 1"),
        ({"class_ids": np.array([1])}, "0 to 0"),
        ({"class_ids": np.array([-1])}, "0 to 0"),
        ({"xywh": np.array([[1.0, 1.0, -1.0, 1.0]])}, "sizes"),
        ({"xywh": np.array([[np.nan, 1.0, 1.0, 1.0]])}, "finite"),
    ],
)
def test_impossible_detections_are_refused(change, words):
    with pytest.raises(ValueError, match=words):
        Detections(**(GOOD | change))


def test_corners_and_names_follow_from_the_boxes():
    found = Detections(**GOOD)
    np.testing.assert_allclose(found.xyxy, [[8, 19, 12, 21]])
    assert found.names == ("aqua",)
    assert len(found) == 1


def test_boxes_are_cut_at_the_border_and_dropped_beyond_it():
    corners = np.array([[-10.0, 5, 10, 15], [90, 40, 130, 60], [200, 10, 220, 20], [0, 0, 100, 50]])
    found = within_image(corners, [0.9, 0.8, 0.7, 0.6], [0, 0, 0, 0], ("aqua",), (100, 50))
    # The whole image of 100 x 50 has its middle at (49.5, 24.5), as camera models count.
    np.testing.assert_allclose(
        found.xywh, [[4.5, 9.5, 10, 10], [94.5, 44.5, 10, 10], [49.5, 24.5, 100, 50]]
    )
    np.testing.assert_allclose(found.scores, [0.9, 0.8, 0.6])
