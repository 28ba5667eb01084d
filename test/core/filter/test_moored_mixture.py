# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Moments over three laws: that robots swim, stay, or drift."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.casting_off import CastingOff
from aerial_gnss_ros.core.filter.moored_mixture import TUNING, MooredGroup, MooredMixture
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL


def law(ids, east, variance):
    """Return a stand-in of a law whose robots are all at one place; the last is its current."""
    mean, covariance = np.zeros((len(ids) + 1, 4)), np.zeros((len(ids) + 1, 4, 4))
    mean[:, 0] = east
    covariance[:] = variance * np.eye(4)
    return SimpleNamespace(
        ids=np.array([*ids, -1]),
        published=lambda: (mean.copy(), covariance.copy()),
        known_current=lambda: (np.array([0.2, 0.1]), 0.01 * np.eye(2)),
        slow_odds=lambda: 0.0,
    )


def group(ids=(5, 7), rows=(1, 0)):
    """Return a group of robots in which no other law is tried."""
    base = SimpleNamespace(
        ids=np.array(ids),
        rows=np.array(rows),
        unseen=np.zeros(len(ids)),
        velocity_changes=SimpleNamespace(position_covariances=np.zeros((len(ids), 2, 2))),
    )
    return MooredGroup(base)


def tried(one, evidence, east, variance, ids=(5, 7), left=()):
    """Let one of a group's hypotheses have a law."""
    one.law, one.evidence = law(ids, east, variance), evidence
    one.leaving = CastingOff(len(ids) + 1)
    for slot, name in enumerate(ids):
        one.leaving.begin(slot, dict(left).get(name, -np.inf))
    one.update = lambda *_: None


def moments(made):
    """Return what a group publishes where robots swim at 0 m with a variance of 1 m²."""
    mean, covariance = np.zeros((2, 4)), np.tile(np.eye(4), (2, 1, 1))
    made.publish(mean, covariance)
    return mean, covariance


def test_moments_are_those_of_the_mixture():
    made = group()
    tried(made.both[0], math.log(2.0), 3.0, 0.1)
    tried(made.both[1], 0.0, -1.0, 0.4)
    np.testing.assert_allclose(made.weights(), [0.25, 0.5, 0.25])
    mean, covariance = moments(made)
    expected = 0.5 * 3.0 - 0.25
    np.testing.assert_allclose(mean[:, 0], expected)
    spread = 0.25 * expected**2 + 0.5 * (3.0 - expected) ** 2 + 0.25 * (1.0 + expected) ** 2
    within = 0.25 + 0.5 * 0.1 + 0.25 * 0.4
    np.testing.assert_allclose(covariance[:, 0, 0], within + spread)
    np.testing.assert_allclose(covariance[:, 1, 1], within)


def test_a_robot_may_have_left_where_a_law_says_that_it_stays():
    made = group()
    one = made.both[0]
    tried(one, 50.0, 3.0, 0.1, left={5: math.log(1.0 / 3.0)})
    one.leaving.mean[0, :, 0], one.leaving.covariance[0] = 2.0, 0.2 * np.eye(4)
    mean, covariance = moments(made)  # robot 5 is in row 1
    assert mean[1, 0] == pytest.approx(3.0 + 0.25 * 2.0)
    assert covariance[1, 0, 0] == pytest.approx(0.1 + 0.25 * 0.2 + 0.25 * 0.75 * 4.0)
    assert mean[0, 0] == pytest.approx(3.0)
    assert covariance[0, 0, 0] == pytest.approx(0.1)


def test_a_robot_that_a_law_does_not_have_swims():
    made = group()
    tried(made.both[0], 50.0, 3.0, 0.1, ids=(7,))
    mean, covariance = moments(made)
    assert (mean[1, 0], covariance[1, 0, 0]) == (0.0, 1.0)
    assert mean[0, 0] == pytest.approx(3.0)


def test_a_robot_that_no_image_shows_may_have_left():
    made = group()
    tried(made.both[0], 50.0, 3.0, 0.1)
    made.base.unseen[0] = MOTION_MODEL.held_s * math.log(4.0)  # robot 5, in row 1
    mean, covariance = moments(made)
    assert mean[1, 0] == pytest.approx(0.25 * 3.0)
    assert covariance[1, 0, 0] == pytest.approx(0.75 + 0.25 * 0.1 + 0.25 * 0.75 * 9.0)
    assert (mean[0, 0], covariance[0, 0, 0]) == pytest.approx((3.0, 0.1))


def test_no_law_falls_farther_behind_than_what_may_have_changed():
    made = group()
    tried(made.both[0], 40.0, 0.0, 1.0)
    tried(made.both[1], 2.0, 0.0, 1.0)
    made.both[0].adrift = made.both[1].adrift = True
    made.both[0].begin_as = lambda *_: None
    made.update(None, None, None, None, 1.0)
    still, drift = (one.evidence for one in made.both)
    assert still == TUNING.swimming_behind_nats
    assert still - drift == TUNING.behind_nats
    swim, stay, adrift = made.weights()
    assert swim == pytest.approx(stay * math.exp(-TUNING.swimming_behind_nats))
    assert adrift == pytest.approx(stay * math.exp(-TUNING.behind_nats))


def test_a_slow_current_is_likelier_than_one_law_says():
    made = group()
    tried(made.both[0], 5.0, 0.0, 1.0)
    tried(made.both[1], 0.0, 0.0, 1.0)
    made.both[0].law.slow_odds = made.both[1].law.slow_odds = lambda: 2.0
    made.both[0].begin_as = lambda *_: None
    swim, stay, adrift = made.weights()
    assert stay == pytest.approx(swim * math.exp(5.0))  # it has no current
    assert adrift == pytest.approx(swim * math.exp(2.0))
    made.update(None, None, None, None, 1.0)
    assert made.both[1].evidence == 0.0  # 3 nats behind
    made.both[1].evidence = -2.0
    made.update(None, None, None, None, 1.0)
    assert made.both[1].odds == made.both[0].odds - TUNING.behind_nats


def test_evidence_that_is_not_strong_stays_as_it_is():
    made = group()
    tried(made.both[0], -3.0, 0.0, 1.0)
    made.both[0].begin_as = lambda *_: None
    made.update(None, None, None, None, 1.0)
    assert made.both[0].evidence == -3.0
    assert made.both[1].evidence == -math.inf
    assert made.weights()[2] == 0.0


def test_nothing_is_put_in_while_the_camera_may_have_turned():
    mixture, made = MooredMixture(), group()
    tried(made.both[0], 50.0, 3.0, 0.1)
    mixture._all = [made]
    mean, covariance = np.zeros((2, 4)), np.tile(np.eye(4), (2, 1, 1))
    made.base.velocity_changes.position_covariances += 0.1
    mixture.publish([made.base], mean, covariance)
    assert not mean.any()
    made.base.velocity_changes.position_covariances[:] = 0.0
    mixture.publish([made.base], mean, covariance)
    assert mean[:, 0] == pytest.approx(3.0)


def test_the_current_is_found_where_robots_drift_and_do_not_stay():
    mixture, made, less = MooredMixture(), group(), group()
    mixture._all = [less, made]
    assert mixture.current() is None
    tried(less.both[1], 0.0, 0.0, 1.0)
    assert mixture.current() is None
    tried(made.both[1], 4.0, 0.0, 1.0)
    current = mixture.current()
    assert current.velocity.tolist() == [0.2, 0.1]
    assert current.covariance[0, 0] == 0.01
    tried(made.both[0], 1.5, 0.0, 1.0)
    assert mixture.current() is None
