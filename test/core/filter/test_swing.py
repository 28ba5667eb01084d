# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The swing is as large as boxes tell."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.swing import TUNING, Swing

STEP_S = 0.1


def after(innovations, variance=0.1**2):
    """Return the swing's variance after images with these innovations (m, 2) each, m²."""
    swing = Swing(4)
    for own in innovations:
        swing.predict(STEP_S)
        swing.update(np.arange(3), np.asarray(own), STEP_S)
    return swing.adapted(variance, 3)


@pytest.mark.parametrize(
    ("innovation", "factor"), [(0.6, TUNING.larger), (0.02, 1.0 / TUNING.larger)]
)
def test_the_swing_is_as_large_as_boxes_tell(innovation, factor):
    assert after([[[innovation] * 2] * 3] * 40) == pytest.approx(0.1**2 * factor)


def test_it_has_bounds_and_waits_for_images():
    assert after([[[0.6] * 2] * 3] * 40, 0.29**2) == TUNING.largest_sway_m**2
    assert after([[[0.0] * 2] * 3] * 40, 0.011**2) == TUNING.least_sway_m**2
    assert after([[[0.6] * 2] * 3] * 10) == 0.1**2


def test_white_noise_leaves_it_as_it_is():
    white = np.random.default_rng(3).standard_normal((600, 3, 2))
    assert after(white) == 0.1**2


def test_robots_that_go_are_forgotten():
    swing = Swing(3)
    swing.update(np.arange(3), np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), STEP_S)
    swing.keep(np.array([True, False, True]), 1)
    assert swing.sums[:, 0].tolist() == [1.0, 3.0, 0.0]
    swing.begin(0)
    assert swing.sums[:, 2].tolist() == [0.0, 1.0, 0.0]
