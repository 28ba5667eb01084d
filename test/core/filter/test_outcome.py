# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fit of an image: of each robot by itself, and of each given all others."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.outcome import Outcome


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
