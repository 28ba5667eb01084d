# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reading the network's output, against hand-made boxes and OpenCV's suppression."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.yolo import Head, iou, suppress


@pytest.mark.parametrize(
    ("shape", "classes", "expected"),
    [
        ((1, 5, 8400), None, Head(1, end_to_end=False)),
        ((1, 5, 8400), 1, Head(1, end_to_end=False)),
        ((1, 84, 8400), 80, Head(80, end_to_end=False)),
        ((1, 300, 6), 1, Head(1, end_to_end=True)),
        ((1, 300, 6), 80, Head(80, end_to_end=True)),
        ((1, 6, 8400), 2, Head(2, end_to_end=False)),
        ((1, 5, 84), 1, Head(1, end_to_end=False)),
    ],
)
def test_heads_are_recognised(shape, classes, expected):
    assert Head.of(shape, classes, "m.onnx") == expected


@pytest.mark.parametrize(
    ("shape", "classes"),
    [((1, 5, 8400), 2), ((1, 1000), 1), ((2, 5, 8400), 1), ((1, 300, 6), None), ((1, 3, 9), None)],
)
def test_other_outputs_are_refused_with_their_shape(shape, classes):
    with pytest.raises(ModelError, match=r"m\.onnx") as caught:
        Head.of(shape, classes, "m.onnx")
    assert str(list(shape)) in str(caught.value)


def test_columns_become_corners_best_first():
    #               centre  size    scores of two classes
    table = np.array(
        [
            [100, 50, 20, 10, 0.3, 0.1],
            [102, 50, 20, 10, 0.6, 0.2],  # the same robot, surer
            [100, 50, 20, 10, 0.1, 0.9],  # another class at the same place
            [300, 80, 40, 30, 0.5, 0.4],
            [500, 80, 40, 30, 0.2, 0.1],  # below the threshold
        ],
        np.float32,
    ).T[None]
    corners, scores, classes = Head(2, end_to_end=False).decode(table, 0.25, 0.5, 10)
    np.testing.assert_allclose(scores, [0.9, 0.6, 0.5], atol=1e-6)
    np.testing.assert_array_equal(classes, [1, 0, 0])
    np.testing.assert_allclose(
        corners, [[90, 45, 110, 55], [92, 45, 112, 55], [280, 65, 320, 95]], atol=1e-5
    )


def test_end_to_end_rows_are_sorted_and_cut():
    rows = np.array([[1, 2, 3, 4, 0.4, 0], [5, 6, 7, 8, 0.8, 2], [0, 0, 0, 0, 0, 0]], np.float32)
    corners, scores, classes = Head(3, end_to_end=True).decode(rows[None], 0.25, 0.5, 10)
    np.testing.assert_allclose(corners, [[5, 6, 7, 8], [1, 2, 3, 4]])
    np.testing.assert_allclose(scores, [0.8, 0.4], atol=1e-6)
    np.testing.assert_array_equal(classes, [2, 0])
    assert len(Head(3, end_to_end=True).decode(rows[None], 0.25, 0.5, 1)[1]) == 1


def test_nothing_found_gives_empty_arrays():
    corners, scores, classes = Head(1, end_to_end=False).decode(
        np.zeros((1, 5, 100), np.float32), 0.25, 0.5, 10
    )
    assert corners.shape == (0, 4)
    assert scores.shape == classes.shape == (0,)


@given(seed=st.integers(0, 2**32 - 1), threshold=st.sampled_from([0.3, 0.5, 0.7]))
def test_suppression_is_that_of_opencv(seed, threshold):
    rng = np.random.default_rng(seed)
    low = rng.uniform(0, 60, (40, 2))
    size = rng.uniform(5, 40, (40, 2))
    scores = np.sort(rng.uniform(0.3, 1.0, 40))[::-1].astype(np.float32)
    theirs = cv2.dnn.NMSBoxes(np.hstack([low, size]).tolist(), scores.tolist(), 0.1, threshold)
    corners = np.hstack([low, low + size])
    ours = suppress(corners, np.zeros(40, np.int64), threshold, 100)
    np.testing.assert_array_equal(ours, np.ravel(theirs))


def test_iou_of_known_boxes():
    a = np.array([[0.0, 0, 10, 10]])
    b = np.array([[0.0, 0, 10, 10], [5, 0, 15, 10], [20, 20, 30, 30], [2, 2, 4, 4]])
    np.testing.assert_allclose(iou(a, b), [[1.0, 1 / 3, 0.0, 0.04]])
