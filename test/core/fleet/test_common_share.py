# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much receivers have in common is weighed by how far apart their offsets are found."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.common_share import CommonShare
from aerial_gnss_ros.core.fleet.receivers import joint_prior
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.position_law import PositionLaw

SIGMA = 1.5
STATED = np.diag([SIGMA**2, SIGMA**2, 0.25, 7e-4, 3e-4, 3e-4, 1e-4, 1e-4, 0.0])


def measured(stationary, share, H, noise, values):
    """Return the law of errors with a prior share and of one robot, after measurements."""
    prior = joint_prior(stationary, share)
    errors = len(prior)
    P = np.zeros((errors + 4, errors + 4))
    P[:errors, :errors], P[errors:, errors:] = prior, np.diag([100.0, 100.0, 0.04, 0.04])
    S = H @ P @ H.T + noise * np.eye(len(H))
    gain = np.linalg.solve(S, H @ P).T
    law = PositionLaw(np.array([0]), gain @ values, P - gain @ H @ P)
    residual = -0.5 * (values @ np.linalg.solve(S, values) + np.linalg.slogdet(S)[1])
    return law, residual


@pytest.mark.parametrize("drones", [2, 3])
def test_it_is_the_mixture_of_filters_that_assume_each_share(drones):
    rng = np.random.default_rng(3)
    stationary = [STATED] * (drones - 1) + [0.2 * STATED]
    errors, bank = COUNT * drones, CommonShare(0.5)
    H = np.zeros((3 * drones, errors + 4))
    H[: 2 * drones, errors : errors + 2] = np.tile(np.eye(2), (drones, 1))  # all see the robot
    H[:, :errors] = rng.normal(size=(3 * drones, errors)) * 0.3
    for k in range(drones):
        H[2 * k : 2 * k + 2, COUNT * k : COUNT * k + 2] += np.eye(2)
    values = rng.normal(size=3 * drones)
    law, _ = measured(stationary, 0.5, H, 0.01, values)
    each = [measured(stationary, share, H, 0.01, values) for share in bank.shares]
    weights = np.exp([log for _, log in each])
    weights /= weights.sum()
    mean = sum(w * one.mean for w, (one, _) in zip(weights, each, strict=True))
    spread = sum(
        w * (one.covariance + np.outer(one.mean - mean, one.mean - mean))
        for w, (one, _) in zip(weights, each, strict=True)
    )
    found = bank.weighed(law, stationary)
    assert bank.weights(law, stationary) == pytest.approx(weights, rel=1e-6)
    assert np.ptp(weights) > 0.02
    np.testing.assert_allclose(found.mean, mean, atol=1e-8)
    np.testing.assert_allclose(found.covariance, spread, atol=1e-8)


def test_offsets_far_apart_speak_for_a_small_share_and_equal_ones_for_a_large_one():
    bank, H = CommonShare(0.5), np.zeros((2, 2 * COUNT + 4))
    H[:, [0, 1]], H[:, [COUNT, COUNT + 1]] = np.eye(2), -np.eye(2)
    mean = []
    for apart in (0.0, 2.0, 4.0):
        law, _ = measured([STATED] * 2, 0.5, H, 1e-4, np.array([apart, 0.0]))
        mean.append(float(bank.weights(law, [STATED] * 2) @ bank.shares))
    assert mean[0] > 0.7
    assert 0.6 > mean[1] > 0.3 > mean[2]


def test_a_share_that_is_stated_as_certain_one_drone_and_an_exact_receiver_change_nothing():
    H = np.zeros((1, 2 * COUNT + 4))
    H[0, 0], H[0, COUNT] = 1.0, -1.0
    law, _ = measured([STATED] * 2, 0.5, H, 0.01, np.array([3.0]))
    exact = STATED.copy()
    exact[:2, :2] = 0.0
    for share, stationary in ((0.0, [STATED] * 2), (1.0, [STATED] * 2), (0.5, [STATED, exact])):
        assert CommonShare(share).weighed(law, stationary) is law
    alone, _ = measured([STATED], 0.5, H[:, : COUNT + 4], 0.01, np.array([3.0]))
    assert CommonShare(0.5).weighed(alone, [STATED]) is alone


def test_a_receiver_that_states_another_error_is_weighed_by_that():
    bank, H = CommonShare(0.5), np.zeros((2, 2 * COUNT + 4))
    H[:, [0, 1]], H[:, [COUNT, COUNT + 1]] = np.eye(2), -np.eye(2)
    for stationary in ([STATED] * 2, [STATED, 0.04 * STATED], [0.04 * STATED] * 2):
        law, _ = measured(stationary, 0.5, H, 0.01, np.array([0.3, -0.2]))
        expected = CommonShare(0.5).weighed(law, stationary)
        np.testing.assert_array_equal(bank.weighed(law, stationary).mean, expected.mean)


def test_its_prior_has_the_stated_mean():
    for share in (0.1, 0.5, 0.8):
        assert CommonShare(share).shares.mean() == pytest.approx(share, abs=0.03)
