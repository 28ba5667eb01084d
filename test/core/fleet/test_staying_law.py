# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a robot that stays tells of all drones is what a dense Gaussian, written out here, says."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.moored_law import TUNING
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.fleet.staying_law import StayingLaw
from aerial_gnss_ros.core.models.platform_model import COUNT

sys.path.insert(0, str(Path(__file__).parent))

from three_drones import MODELS, MOTION, PLACES, STATIONARY, sight

ERRORS = COUNT * len(MODELS)


def seen(state, drone, shift, off):
    """Let a drone's image show the robots, displaced by pixels `off`."""
    view = sight(drone, shift)
    state.look(drone, view)
    pixels = linearise(view, np.zeros(COUNT), PLACES).pixels + off
    outcome = state.correct(np.arange(3), pixels, view, MODELS[drone])
    return outcome, pixels, view


@pytest.fixture
def swimming():
    """Robots that three drones have seen twice."""
    state, view, rng = SharedState(STATIONARY, 0.5), sight(0), np.random.default_rng(3)
    state.look(0, view)
    pixels = linearise(view, np.zeros(COUNT), PLACES).pixels
    state.begin(np.arange(3), pixels, view, MODELS[0], 0.75)
    state.settle()
    for k in range(6):
        state.predict(0.2, [m.decay(0.2) for m in MODELS], STATIONARY, MOTION)
        seen(state, k % 3, 0.1 * k, rng.normal(0.0, 1.0, (3, 2)))
        state.settle()
    return state


def velocity(slot):
    return ERRORS + 4 * slot + np.array([2, 3])


def test_that_a_robot_stays_conditions_all_drones(swimming):
    law = StayingLaw.beside(swimming)
    mean, P = swimming.ordered()
    v = velocity(1)
    gain = np.linalg.solve(P[np.ix_(v, v)] + TUNING.apart_mps**2 * np.eye(2), P[v])
    mean, P = mean - mean[v] @ gain, P - P[v].T @ gain
    before = swimming.ordered()
    law.moor(1)
    found, Q = law.shared.ordered()
    rest = np.setdiff1d(np.arange(len(mean)), [*v, ERRORS + 4, ERRORS + 5])
    np.testing.assert_allclose(found[rest], mean[rest], atol=1e-12)
    np.testing.assert_allclose(Q[np.ix_(rest, rest)], P[np.ix_(rest, rest)], atol=1e-12)
    assert np.linalg.eigvalsh(Q).min() > -1e-12
    others = slice(7, ERRORS)
    assert np.trace(Q[others, others]) < np.trace(before[1][others, others])
    np.testing.assert_array_equal(swimming.ordered()[1], before[1])  # which knows nothing of it


def test_without_a_robot_that_stays_it_is_the_state_in_which_all_swim(swimming):
    law, rng = StayingLaw.beside(swimming), np.random.default_rng(5)
    for k in range(6):
        keep = [m.decay(0.2) for m in MODELS]
        law.shared.predict(0.2, keep, STATIONARY, MOTION)
        swimming.predict(0.2, keep, STATIONARY, MOTION)
        law.shared.look(k % 3, sight(k % 3, 0.3 * k))
        outcome, pixels, view = seen(swimming, k % 3, 0.3 * k, rng.normal(0.0, 1.0, (3, 2)))
        law.shared.look(k % 3, view)
        found = law.fit(np.arange(3), pixels, view, MODELS[k % 3], 1.0)
        assert found.log_likelihood == pytest.approx(outcome.log_likelihood, abs=1e-6)
        law.shared.settle()
        swimming.settle()
    (mean, P), (other, Q) = law.shared.ordered(), swimming.ordered()
    own = np.arange(len(other))
    np.testing.assert_allclose(mean[own], other, atol=1e-7)
    np.testing.assert_allclose(P[np.ix_(own, own)], Q, atol=1e-7)


def test_one_that_leaves_is_where_it_was_shown_and_moves(swimming):
    law = StayingLaw.beside(swimming)
    law.moor(1)
    for k in range(3):
        law.shared.predict(0.2, [m.decay(0.2) for m in MODELS], STATIONARY, MOTION)
        view = sight(k)
        law.shared.look(k, view)
        pixels = linearise(view, np.zeros(COUNT), PLACES).pixels
        law.fit(np.arange(3), pixels, view, MODELS[k], 1.0)
        law.shared.settle()
    before, P = law.shared.ordered()
    p, v = velocity(1) - 2, velocity(1)
    shown = before[p] + before[v]
    spread = P[p] + P[v]
    more = np.diag([0.01, 0.01, 0.04, 0.04])
    law.release(1, np.array([0.1, 0.2, 0.3, 0.4]), more)
    after, Q = law.shared.ordered()
    np.testing.assert_allclose(after[p] - shown, [0.1, 0.2], atol=1e-12)
    np.testing.assert_allclose(after[v], [0.3, 0.4], atol=1e-12)
    np.testing.assert_allclose(Q[p][:, :ERRORS], spread[:, :ERRORS], atol=1e-12)
    np.testing.assert_allclose(Q[v][:, :ERRORS], 0.0, atol=1e-12)


@pytest.mark.parametrize("active", [0, 2])
def test_a_robot_is_taken_over_given_the_errors_of_all_drones(swimming, active):
    law = StayingLaw.beside(swimming)
    law.moor(0)
    law.shared.activate(active)
    swimming.activate(1)
    (place,) = np.flatnonzero(law.ids == swimming.joint.ids[2])
    law.drop(np.array([place]))
    law.take(swimming.joint, 2)
    given = []
    for state, slot in ((law.shared, len(law) - 1), (swimming, 2)):
        mean, P = state.ordered()
        own, errors = ERRORS + 4 * slot + np.arange(4), np.arange(ERRORS)
        known = np.linalg.pinv(P[np.ix_(errors, errors)], hermitian=True)
        by_errors = P[np.ix_(own, errors)] @ known
        rest = P[np.ix_(own, own)] - by_errors @ P[np.ix_(errors, own)]
        given.append((mean[errors], mean[own] - by_errors @ mean[errors], by_errors, rest))
    assert np.abs(given[0][0] - given[1][0]).max() > 1e-4  # the law has learnt more of the errors
    for one, other in zip(given[0][1:], given[1][1:], strict=True):
        np.testing.assert_allclose(one, other, atol=1e-4)
    P = law.shared.ordered()[1]
    assert law.ids[-1] == swimming.joint.ids[2]
    assert np.linalg.eigvalsh(P).min() > -1e-12


def test_what_is_uncertain_of_a_robot_alone_leaves_out_what_all_drones_are(swimming):
    law = StayingLaw.beside(swimming)
    law.moor(0)
    found = law.own_covariances(np.array([0, 1]))
    _, P = law.shared.ordered()
    for slot, shown in ((0, [1, 1]), (1, [1, 0])):
        H = np.zeros((2, len(P)))
        H[:, ERRORS + 4 * slot : ERRORS + 4 * slot + 4] = np.kron(shown, np.eye(2))
        both = np.vstack([H, np.eye(len(P))[:ERRORS]])
        spread = both @ P @ both.T
        known = np.linalg.pinv(spread[2:, 2:], hermitian=True)
        given = spread[:2, :2] - spread[:2, 2:] @ known @ spread[2:, :2]
        np.testing.assert_allclose(found[slot], given, atol=1e-6)


def test_half_of_a_swing_is_published_as_the_robot_s(swimming):
    law = StayingLaw.beside(swimming)
    law.moor(0)
    law.robots[0, 2:] = 0.2, -0.1
    mean, P = law.jointly_published()
    inside, Q = law.shared.ordered()
    place = slice(ERRORS, ERRORS + 2)
    np.testing.assert_allclose(mean[place] - inside[place], [0.1, -0.05])
    np.testing.assert_allclose(mean[ERRORS + 2 : ERRORS + 4], 0.0)
    np.testing.assert_allclose(P[:ERRORS, :ERRORS], Q[:ERRORS, :ERRORS])
