# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether moored robots have left: odds, where they then are, and covariances that cover it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.casting_off import TUNING, CastingOff

STEP_S = 0.1
DENSITY = 0.05**2
BY_PLACE = np.array([[20.0, 0.0], [5.0, 15.0]])
SPREAD = np.array([[4.0, 1.0], [1.0, 4.0]])
ROOT = np.linalg.cholesky(SPREAD)
LAW_M = 0.05
"""Sigma of a robot's place that stays, each axis."""


def asked(count):
    """Return robots that may leave from now on."""
    one = CastingOff(count)
    for slot in range(count):
        one.begin(slot, -5.0)
    return one


def shown(one, away, rng, followed=0.0):
    """Let an image show robots that are away (n, 2) from where a law has them, m."""
    n = len(away)
    white = rng.standard_normal((n, 2)) @ ROOT.T
    one.predict(STEP_S, DENSITY)
    return one.update(
        np.arange(n),
        away @ BY_PLACE.T + white,
        np.tile(SPREAD, (n, 1, 1)),
        np.tile(BY_PLACE, (n, 1, 1)),
        np.tile(followed * np.eye(2), (n, 1, 1)),
    )


def nees(one, away, rng):
    """Return squared distances (n,) of where robots are, by the covariances of the mixture."""
    n = len(away)
    states, covariances = np.zeros((n, 4)), np.tile(LAW_M**2 * np.eye(4), (n, 1, 1))
    mean, covariance = one.mix(np.arange(n), states, covariances)
    off = away + LAW_M * rng.standard_normal((n, 2)) - mean[:, :2]
    return np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance[:, :2, :2]), off)


@pytest.mark.parametrize("speed_mps", [0.1, 0.3, 0.6])
def test_covariances_cover_robots_that_leave(speed_mps):
    one, rng = asked(300), np.random.default_rng(5)
    course = rng.uniform(-math.pi, math.pi, 300)
    velocity = speed_mps * np.stack([np.cos(course), np.sin(course)], axis=1)
    left_s = rng.uniform(5.0, 5.5, 300)
    squared = []
    for step in range(1, 101):
        since = np.maximum(STEP_S * step - left_s, 0.0)
        away = since[:, None] * velocity
        shown(one, away, rng)
        if step == 50:
            assert nees(one, away, rng).mean() / 2.0 == pytest.approx(0.95, abs=0.25)
        if step > 50:
            squared.append(nees(one, away, rng))
    whole = np.array(squared)
    assert 0.5 < whole.mean() / 2.0 < 2.0
    assert (whole > 13.8).mean() < 0.03
    assert (one.odds > 3.0).all()
    mean, covariance = zip(*[one.gone(slot) for slot in range(300)], strict=True)
    off = np.array(mean) - np.concatenate([away, velocity], axis=1)
    spread = np.linalg.inv(np.array(covariance))
    assert np.einsum("ni,nij,nj->n", off, spread, off).mean() / 4.0 == pytest.approx(0.8, abs=0.5)


def test_robots_that_stay_are_hardly_doubted():
    one, rng = asked(200), np.random.default_rng(6)
    gained = sum(shown(one, np.zeros((200, 2)), rng) for _ in range(200))
    assert np.median(one.odds) < -4.0
    assert (one.odds > 3.0).mean() <= 0.01
    assert abs(gained) / 200 < 0.2  # the mixture explains them as well as that none leaves


def test_a_law_that_follows_hides_what_it_has_followed():
    one, rng = asked(1), np.random.default_rng(7)
    away, seen = np.zeros((1, 2)), 0.0
    for _ in range(60):
        seen = seen + 0.4 * STEP_S
        away = away + np.array([0.4 * STEP_S, 0.0])
        shown(one, away, rng, followed=0.05)
        away = away * 0.95
    mean, _ = one.gone(0)
    assert one.odds[0] > 3.0
    assert away[0, 0] < 0.5 * seen
    assert mean[0] == pytest.approx(away[0, 0], abs=0.1)
    assert mean[2] == pytest.approx(0.4, abs=0.1)


def test_time_alone_makes_it_likelier_that_a_robot_has_left():
    one = asked(1)
    for _ in range(600):
        one.predict(STEP_S, DENSITY)
    stays = math.exp(-60.0 * TUNING.rate_hz) / (1.0 + math.exp(-5.0))
    assert one.odds[0] == pytest.approx(math.log((1.0 - stays) / stays))


def test_a_robot_that_is_not_asked_for_has_not_left():
    one, rng = asked(2), np.random.default_rng(8)
    one.end(1)
    for _ in range(20):
        one.predict(STEP_S, DENSITY)
    assert one.odds[1] == -np.inf
    states, covariances = rng.standard_normal((2, 4)), np.tile(np.eye(4), (2, 1, 1))
    mean, covariance = one.mix(np.arange(2), states, covariances)
    np.testing.assert_array_equal(mean[1], states[1])
    np.testing.assert_array_equal(covariance[1], covariances[1])
    assert covariance[0, 2, 2] > 1.0
