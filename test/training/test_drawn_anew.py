# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Standard errors of scores, where they can be worked out otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.average_precision import average_precision
from aerial_gnss_ros.training.drawn_anew import draws, figures_of_draws
from aerial_gnss_ros.training.labelled import Truth


def image(hit: bool, false: int = 0) -> tuple[Detections, Truth]:
    """One robot, found or not, and so many boxes elsewhere."""
    boxes = [[20.0, 10.0, 40.0, 20.0]] * hit + [[300.0, 300.0, 40.0, 20.0]] * false
    xywh = np.array(boxes).reshape(-1, 4)
    found = Detections(xywh, np.full(len(xywh), 0.9), np.zeros(len(xywh), np.int64), ("aqua",))
    corners = np.array([[0.0, 0.0, 40.0, 20.0]])
    return found, Truth(corners, np.ones(1, bool), np.full(1, 40.0), np.ones(1), np.zeros(1, int))


def test_a_draw_takes_whole_scenes_and_equal_seeds_take_the_same():
    picks = draws(12, 5, 50)  # scenes of 5, 5 and 2
    for pick in picks:
        times = np.bincount(pick, minlength=12)
        assert [len(set(times[part])) for part in (slice(0, 5), slice(5, 10), slice(10, 12))] == [
            1, 1, 1,
        ]  # fmt: skip
        assert times[0] + times[5] + times[10] == 3
    assert all((a == b).all() for a, b in zip(picks, draws(12, 5, 50), strict=True))


def test_figures_of_picked_images_by_hand():
    pairs = [image(True), image(False), image(True, false=2)]
    got = figures_of_draws(pairs, [np.array([0, 1, 2]), np.array([0, 0, 1]), np.array([1])], 0.3)
    assert got["recall"].tolist() == pytest.approx([2 / 3, 2 / 3, 0])
    assert got["precision"].tolist() == pytest.approx([2 / 4, 1, 0])
    assert got["map50"][0] == pytest.approx(average_precision(pairs).map50)
    assert got["map50_95"][1] == pytest.approx(67 / 101)  # recalls 0, 0.01 ... 0.66


def test_the_spread_is_the_binomial_error_of_independent_images():
    pairs = [image(i % 4 > 0) for i in range(200)]  # three of four found
    spread = figures_of_draws(pairs, draws(200, 1, 600), 0.3)["recall"].std()
    assert spread == pytest.approx(np.sqrt(0.75 * 0.25 / 200), rel=0.15)


def test_images_of_one_scene_that_fail_together_are_less_sure():
    """Scenes of four alike: as sure as a quarter of the images."""
    pairs = [image(i // 4 % 4 > 0) for i in range(200)]
    spread = figures_of_draws(pairs, draws(200, 4, 600), 0.3)["recall"].std()
    assert spread == pytest.approx(np.sqrt(0.74 * 0.26 / 50), rel=0.15)
