# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The best score threshold, on boxes that can be counted by hand."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.held_out import best_threshold
from aerial_gnss_ros.training.labelled import Truth


def pair(scores, right):
    """An image with three robots in a row; box i is on robot i or, if wrong, far off."""
    centres = np.array([[50.0 * i, 20.0 if ok else 400.0] for i, ok in enumerate(right)])
    boxes = np.hstack([centres.reshape(-1, 2), np.full((len(scores), 2), 20.0)])
    classes = np.zeros(len(scores), np.int64)
    middles = np.array([[50.0 * i, 20.0] for i in range(3)])
    truth = Truth(
        np.hstack([middles - 10.0, middles + 10.0]), np.ones(3, bool), np.full(3, 20.0),
        np.full(3, np.nan), np.zeros(3, np.int64),
    )  # fmt: skip
    return Detections(boxes, np.array(scores), classes, ("aqua",)), truth


@pytest.mark.parametrize(
    ("scores", "right", "expected"),
    [
        # From 0.35 to 0.60 all three are found and nothing else: F1 is 1.
        ([0.9, 0.7, 0.62, 0.31], [1, 1, 1, 0], (0.5, 1.0)),
        # Only the first is found, without a false box, above 0.5: F1 is 2 * 1 / (3 + 1).
        ([0.9, 0.5, 0.5], [1, 0, 0], (0.75, 0.5)),
        ([], [], (np.nan, np.nan)),
        ([0.9], [0], (np.nan, np.nan)),
    ],
)
def test_the_middle_of_the_best_thresholds(scores, right, expected):
    np.testing.assert_allclose(best_threshold([pair(scores, right)]), expected)
