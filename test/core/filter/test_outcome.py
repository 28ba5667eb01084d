# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fit of an image: of some robots, of each by itself, and of each given all others."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.update import correct

sys.path.insert(0, str(Path(__file__).parent))

from three_robots import MODEL, crowd, sight


def test_the_fit_of_some_robots_is_that_of_an_update_by_them_alone():
    whole, alone = crowd(), crowd()
    slots = np.array([2, 0, 1])
    pixels = linearise(sight(), whole.mean[:7], whole.robots[slots, :2]).pixels
    pixels = pixels + np.array([[1.5, -2.0], [0.5, 1.0], [-1.0, 0.3]])
    outcome = correct(whole, slots, pixels, sight(), MODEL)
    expected = correct(alone, slots[:2], pixels[:2], sight(), MODEL)
    squared, count = outcome.fit_of(np.array([0, 2]))
    assert (squared, count) == (pytest.approx(expected.squared), 4)
    assert outcome.fit_of(slots) == (outcome.squared, 6)
    assert outcome.fit_of(np.zeros(0, int)) == (0.0, 0)


@pytest.fixture
def correlated():
    """The outcome of three robots whose boxes have a large error in common."""
    rng = np.random.default_rng(4)
    root = rng.normal(0.0, 1.0, (6, 6)) + 3.0
    spread = root @ root.T
    return Outcome(0.0, 6, slots=np.arange(3), residual=rng.normal(0.0, 3.0, (3, 2)), spread=spread)


def test_a_residual_by_its_own_covariance_is_white(correlated):
    found = correlated.normalised()
    for i in range(3):
        own = correlated.spread[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
        expected = np.linalg.solve(np.linalg.cholesky(own), correlated.residual[i])
        np.testing.assert_allclose(found[i], expected)


def test_a_residual_given_all_others_is_the_conditional_one(correlated):
    residual, covariance = correlated.given_others()
    spread, told = correlated.spread, correlated.residual.ravel()
    for i in range(3):
        own, rest = np.arange(2 * i, 2 * i + 2), np.delete(np.arange(6), [2 * i, 2 * i + 1])
        gain = spread[np.ix_(own, rest)] @ np.linalg.inv(spread[np.ix_(rest, rest)])
        np.testing.assert_allclose(residual[i], told[own] - gain @ told[rest])
        left = spread[np.ix_(own, own)] - gain @ spread[np.ix_(rest, own)]
        np.testing.assert_allclose(covariance[i], left)
