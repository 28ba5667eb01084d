# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Slow errors have the stated size and correlation; streams do not disturb one another."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.simulation.chance import Drift, Wander, generator


def test_drift_is_stationary_gauss_markov():
    """Over 4000 draws: sigma at every time, and exp(-dt / T) between two times."""
    times = np.array([0.0, 10.0, 30.0])
    draws = np.array(
        [Drift(generator(seed, "x"), 2.0, 20.0, -1.0, 31.0)(times) for seed in range(4000)]
    )
    np.testing.assert_allclose(draws.std(axis=0), 2.0, rtol=0.04)
    np.testing.assert_allclose(draws.mean(axis=0), 0.0, atol=0.12)
    correlation = np.corrcoef(draws.T)
    assert correlation[0, 1] == pytest.approx(math.exp(-0.5), abs=0.04)
    assert correlation[0, 2] == pytest.approx(math.exp(-1.5), abs=0.05)


def test_an_endless_correlation_is_a_constant_and_none_is_white():
    t = np.arange(0.0, 50.0, 0.1)
    assert np.ptp(Drift(generator(1, "x"), 1.0, math.inf, 0.0, 50.0)(t)) == 0.0
    white = Drift(generator(1, "x"), 1.0, 0.0, 0.0, 50.0)(t)
    assert abs(np.corrcoef(white[:-1], white[1:])[0, 1]) < 0.15


def test_wandering_has_its_root_mean_square():
    t = np.arange(0.0, 2000.0, 0.1)
    assert Wander(generator(2, "x"), 0.3, 0.1, 0.5)(t).std() == pytest.approx(0.3, rel=0.05)


def test_streams_are_independent_by_name_and_equal_by_seed():
    first, same, other = (
        generator(seed, name).standard_normal(1000) for seed, name in ((1, "a"), (1, "a"), (1, "b"))
    )
    np.testing.assert_array_equal(first, same)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.1
