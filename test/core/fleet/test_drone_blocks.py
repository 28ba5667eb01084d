# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One Gaussian, whichever drone's part is the active one."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.drone_blocks import DroneBlocks, discounted
from aerial_gnss_ros.core.models.platform_model import COUNT

STATIONARY = [np.diag([v, v, 1.0, *[0.1] * 5, 0.04]) for v in (1.44, 4e-4, 1.44)]
ERRORS = len(STATIONARY) * COUNT


def blocks():
    """Three drones and two robots, seen by the first drone with a receiver's offset alone."""
    state = DroneBlocks(STATIONARY, 0.5)
    by_errors = np.zeros((2, 4, COUNT))
    by_errors[:, 0, 0] = by_errors[:, 1, 1] = 1.0
    own = np.tile(np.diag([0.04, 0.04, 0.25, 0.25]), (2, 1, 1))
    states = np.array([[1.0, 2.0, 0.1, 0.0], [1.6, 2.8, 0.0, 0.1]])
    state.joint.append(np.arange(2), states, by_errors, own)
    through = by_errors.reshape(-1, COUNT) @ state._cross
    state._cross = np.concatenate([state._cross, through])
    return state


def test_the_order_in_which_drones_were_active_is_no_information():
    state = blocks()
    before = state.ordered()
    state.assume(2, np.arange(float(COUNT)))
    before[0][2 * COUNT : 3 * COUNT] = np.arange(float(COUNT))
    for drone in (2, 0, 1, 2, 1):
        state.activate(drone)
        for one, other in zip(before, state.ordered(), strict=True):
            np.testing.assert_array_equal(one, other)
        assert state.active == drone
        for other in range(3):
            place = slice(COUNT * other, COUNT * other + COUNT)
            np.testing.assert_array_equal(state.platform(other)[0], before[0][place])
            np.testing.assert_array_equal(state.platform(other)[1], before[1][place, place])
    for one, other in zip(state.platforms(), before, strict=True):
        np.testing.assert_array_equal(one, other[(slice(ERRORS),) * one.ndim])


def test_a_receiver_that_jumped_is_as_unknown_as_at_first_and_nothing_else_is_lost():
    state = blocks()
    robots = state.joint.blocks()
    state.forget_gnss(0, STATIONARY)
    P = state.ordered()[1]
    np.testing.assert_array_equal(robots, state.joint.blocks())
    assert np.linalg.eigvalsh(P).min() > -1e-12
    # Nothing was learned of the receivers: it is as before any image.
    np.testing.assert_allclose(P[:ERRORS, :ERRORS], state.prior(STATIONARY), atol=1e-12)
    # Robots no longer hang on its offset, but by what the third receiver has in common with it.
    assert P[0, ERRORS] == pytest.approx(0.25 * 1.44, rel=0.01)


def test_a_tie_is_an_update_by_two_robots_at_one_place():
    state = blocks()
    mean, P = state.ordered()
    H = np.zeros((2, len(mean)))
    H[:, ERRORS : ERRORS + 2], H[:, ERRORS + 4 : ERRORS + 6] = np.eye(2), -np.eye(2)
    S = H @ P @ H.T + 0.1**2 * np.eye(2)
    offset = H @ mean
    assert state.apart(0, 1, 0.1) == pytest.approx(offset @ np.linalg.solve(S, offset))
    gain = P @ H.T @ np.linalg.inv(S)
    state.tie(0, 1, 0.1)
    found = state.ordered()
    np.testing.assert_allclose(found[0], mean - gain @ offset, atol=1e-12)
    np.testing.assert_allclose(found[1], P - gain @ H @ P, atol=1e-12)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_what_counts_less_is_as_if_its_noise_had_been_larger(share):
    prior = DroneBlocks(STATIONARY, share).prior(STATIONARY)
    H = np.random.default_rng(4).normal(size=(9, ERRORS))
    gain = prior @ H.T @ np.linalg.inv(H @ prior @ H.T + 0.3 * np.eye(9))
    mean, P = gain @ np.ones(9), prior - gain @ H @ prior
    moved, wider = discounted(mean, P, prior, 4.0)
    # As if the noise of these measurements had had four times the variance.
    other = prior @ H.T @ np.linalg.inv(H @ prior @ H.T + 1.2 * np.eye(9))
    np.testing.assert_allclose(mean + moved, other @ np.ones(9), atol=1e-6)
    np.testing.assert_allclose(P + wider, prior - other @ H @ prior, atol=1e-6)
