# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Models side by side on the same images, with numbers that can be counted by hand."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.training.average_precision import LOWEST_SCORE
from aerial_gnss_ros.training.compare import compare, for_scoring, table
from aerial_gnss_ros.training.labelled import LabelledImage

sys.path.insert(0, str(Path(__file__).parent))

from scored import ROBOT, found, truth


class Told:
    """A detector that returns the given boxes, image by image."""

    class_names = ("aqua",)

    def __init__(self, name, *images):
        self.name, self._images = name, iter(images)

    def detect(self, image):
        assert image.shape == (9, 9, 3)
        return next(self._images)


def test_figures_and_shifts_from_the_first_model():
    """The other one is 3 px to the right, 4 px below, and finds no robot in the second image."""
    read = lambda: np.zeros((9, 9, 3), np.uint8)  # noqa: E731
    images = [LabelledImage(name, truth(ROBOT), read) for name in "ab"]
    exact = Told("exact", *[found((0, 0, 40, 20, 0.9))] * 2)
    off = Told("off", found((3, 4, 43, 24, 0.9), (300, 0, 340, 20, 0.8)), found())
    done = []
    first, second = compare([exact, off], images, done.append)
    assert done == [1, 2]
    assert (first.images, first.precision, first.recall) == (2, 1.0, 1.0)
    assert (first.map50, first.centre_shift_p95_px) == (1.0, 0.0)
    assert (second.precision, second.recall) == (0.5, 0.5)
    assert second.centre_error_median_px == pytest.approx(5.0)
    assert second.centre_shift_p95_px == pytest.approx(np.percentile([0.0, 5.0], 95))
    rows = table([first, second]).splitlines()
    assert rows[2].startswith("| exact | 100.00 (+0.00) | 100.00 (+0.00) | 1.000 | 1.000 | 0.00 |")
    loss = 100.0 * (second.map50 - 1.0)
    assert f"| {100.0 * second.map50:.2f} ({loss:+.2f}) | 0.500 | 0.500 | 5.00 |" in rows[3]


def test_a_model_is_scored_alone_and_down_to_the_lowest_score():
    config = for_scoring(DetectorConfig(score_threshold=0.7, second_look="auto"))
    assert (config.score_threshold, config.second_look) == (LOWEST_SCORE, "off")
