# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A law in which robots are moored: what joining, leaving and a zero current change."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.moored_law import CURRENT, TUNING, MooredLaw
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT

sys.path.insert(0, str(Path(__file__).parent))

from swimming_robots import swimming

MOTION = MotionModel(0.05, 1.0)


def moored(*velocities, adrift=True):
    """Return a law in which all robots are moored."""
    law = MooredLaw.of(swimming(*velocities), adrift)
    for slot in range(len(velocities)):
        law.moor(slot)
    return law


def test_what_drifts_is_carried_by_the_current_and_is_not_moored():
    law = moored((0.2, 0.1), (0.2, 0.1))
    assert law.still_odds() < -20.0
    before = law.robots[:2, :2].copy()
    law.predict(10.0, np.ones(COUNT), 0.01 * np.eye(COUNT), MOTION)
    np.testing.assert_allclose(law.robots[:2, :2] - before, [[2.0, 1.0]] * 2, rtol=0.05)
    mean, covariance = law.published()
    np.testing.assert_allclose(mean[:2, 2:], [[0.2, 0.1]] * 2, rtol=0.05)
    changed = 1.0 - np.exp(-20.0 / TUNING.current_s)
    assert covariance[0, 2, 2] > changed * TUNING.current_mps**2


def test_what_stays_does_so_for_good_and_is_known_the_better():
    law = moored((0.005, 0.0), (0.0, -0.004), (-0.003, 0.0))
    assert law.still_odds() > 3.0
    still = law.without_current()
    place = still.robots[:3, :2].copy()
    for one in (law, still):
        one.predict(30.0, np.ones(COUNT), 0.01 * np.eye(COUNT), MOTION)
    np.testing.assert_array_equal(still.robots[:3, :2], place)
    known, less = still.published()[1], law.published()[1]
    assert known[:3, 0, 0].max() < 0.5 * less[:3, 0, 0].min()
    np.testing.assert_array_equal(still.robots[still.current, 2:], 0.0)
    np.linalg.cholesky(law.covariance)


def test_without_a_current_places_are_what_they_were_if_there_was_none():
    """What places share with the current is taken back: they lie where no drift explains them."""
    law = moored((0.1, 0.0), (0.1, 0.0))
    law.predict(2.0, np.ones(COUNT), 0.01 * np.eye(COUNT), MOTION)
    still = law.without_current()
    assert np.all(still.robots[:2, 0] < law.robots[:2, 0] - 0.1)
    assert np.all(still.covariance.diagonal() <= law.covariance.diagonal() + 1e-12)
    assert still.covariance[COUNT, COUNT] < 0.99 * law.covariance[COUNT, COUNT]
    assert law.robots[law.current, 2] == pytest.approx(0.1, rel=0.05)
    assert moored((0.1, 0.0), adrift=False).robots[0, 0] == 0.0


def test_leaving_undoes_joining_but_for_what_joining_showed():
    law = MooredLaw.of(swimming((0.1, 0.0), (0.0, 0.0)), adrift=True)
    place = law.robots[0, :2].copy()
    law.moor(0)
    np.testing.assert_allclose(law.shown(np.array([0]))[0], place, atol=1e-9)
    law.mean[COUNT + 2] = 0.07  # swung to the east
    away, spread = np.array([0.2, 0.0, 0.3, -0.1]), np.diag([0.1, 0.1, 0.2, 0.2])
    law.release(0, away, spread)
    assert law.sway[0] == 0.0
    np.testing.assert_allclose(law.robots[0, :2], place + np.array([0.27, 0.0]), atol=1e-9)
    np.testing.assert_allclose(law.robots[0, 2:], law.robots[law.current, 2:] + away[2:])
    assert law.covariance[COUNT + 2, COUNT + 2] > 0.2
    np.linalg.cholesky(law.covariance)


def test_half_of_a_swing_is_published_and_covered():
    law = moored((0.0, 0.0), (0.0, 0.0))
    place, alone = law.robots[0, 0], law.published()[1][0, 0, 0]
    law.mean[COUNT + 2] = 0.4
    mean, covariance = law.published()
    assert mean[0, 0] - place == pytest.approx(0.2)
    assert covariance[0, 0, 0] - alone == pytest.approx(0.2**2)


def test_a_swing_is_forgotten_and_comes_again():
    law = moored((0.0, 0.0))
    law.mean[COUNT + 2] = 0.1
    law.predict(3.0, np.ones(COUNT), 0.01 * np.eye(COUNT), MOTION)
    assert law.robots[0, 2] == pytest.approx(0.1 / np.e)
    assert law.covariance[COUNT + 2, COUNT + 2] == pytest.approx(law.variance)


def test_the_current_stays_when_robots_go():
    law = moored((0.0, 0.0), (0.0, 0.0))
    law.drop(np.array([0]))
    assert law.ids.tolist()[-1] == CURRENT
    assert law.sway.tolist() == [1.0, 0.0]


def test_what_is_published_jointly_is_what_is_published_of_each():
    law = moored((0.21, 0.0), (0.2, 0.01))
    law.release(1, np.zeros(4), np.eye(4))
    law.mean[COUNT + 2] = 0.3  # swing of the first one, of which half is its own
    states, blocks = law.published()
    mean, covariance = law.jointly_published()
    assert mean[COUNT:].reshape(-1, 4) == pytest.approx(states)
    n = len(law)
    own = covariance[COUNT:, COUNT:].reshape(n, 4, n, 4)[np.arange(n), :, np.arange(n)]
    assert own == pytest.approx(blocks)
    assert covariance == pytest.approx(covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9
    current = slice(COUNT + 4 * law.current + 2, COUNT + 4 * law.current + 4)
    swaying, other = slice(COUNT + 2, COUNT + 4), slice(COUNT + 4, COUNT + 8)
    assert covariance[swaying, other] == pytest.approx(law.covariance[current, other])


@pytest.mark.parametrize(("velocity", "sigma"), [((0.05, 0.02), 0.02), ((0.3, 0.2), 0.05)])
def test_a_slow_current_is_as_likely_as_a_fast_one(velocity, sigma):
    """The mean of the ratio of both densities, over draws of what is known of the current."""
    law = moored((0.0, 0.0), (0.0, 0.0))
    law.known_current = lambda: (np.array(velocity), sigma**2 * np.eye(2))
    draws = np.random.default_rng(1).normal(velocity, sigma, (200_000, 2))
    squared = (draws**2).sum(axis=1)
    sigmas = (TUNING.current_mps, *TUNING.slower_mps)
    densities = [np.exp(-0.5 * squared / one**2) / one**2 for one in sigmas]
    ratio = np.mean(np.mean(densities, axis=0) / densities[0])
    assert law.slow_odds() == pytest.approx(np.log(ratio), abs=0.02)


def test_a_moored_robot_is_joined_with_what_is_found_where_it_is_shown():
    """Both are weighed by their covariances, the swing included, and the platform learns of it."""
    base = JointState(0.25 * np.eye(COUNT))
    by_platform = np.zeros((2, 4, COUNT))
    by_platform[1, 0, 0] = 1.0  # the second one is as far east as the receiver's error says
    states = np.array([[1.0, 2.0, 0.3, 0.0], [2.0, 2.0, 0.0, 0.0]])
    own = np.tile(np.diag([0.04, 0.04, 0.01, 0.01]), (2, 1, 1))
    base.append(np.arange(2), states, by_platform, own)
    law = MooredLaw.of(base, adrift=False)
    number = law.ids[1]
    law.sway[0] = 1.0
    apart, spread = law.join(0, 1, 0.1)
    np.testing.assert_allclose(apart, [0.7, 0.0], atol=1e-12)
    np.testing.assert_allclose(np.diag(spread), [0.04 + 0.01 + 0.04 + 0.25 + 0.01, 0.1])
    assert law.ids[0] == number
    # The receiver's error explains 0.25 / 0.35 of what they are apart.
    assert law.mean[0] == pytest.approx(-0.7 * 0.25 / 0.35)
    assert law.covariance[0, 0] == pytest.approx(0.25 - 0.25**2 / 0.35)
    assert law.robots[0, 0] + law.robots[0, 2] == pytest.approx(1.3 + 0.7 * 0.05 / 0.35)


def test_joining_changes_nothing_that_the_base_has():
    base = JointState(0.25 * np.eye(COUNT))
    own = np.tile(np.eye(4), (2, 1, 1))
    base.append(np.arange(2), np.zeros((2, 4)), np.zeros((2, 4, COUNT)), own)
    law = MooredLaw.of(base, adrift=False)
    before = base.ids.tolist(), base.rows.tolist()
    law.sway[0] = 1.0
    law.join(0, 1, 0.1)
    assert (base.ids.tolist(), base.rows.tolist()) == before
    assert law.rows[0] == law.rows[1]
