# SPDX-License-Identifier: Apache-2.0
"""The filter against integrals, batch least squares and a bias that is really there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core import filter as kalman

NO_SLOW = np.zeros((1, 2, kalman.SLOW_COUNT))
NO_DRIFT = np.zeros((1, 2, 2))


def _one(position=(0.0, 0.0), sigma=1.0, speed=1.0, slow=NO_SLOW):
    return kalman.begin(np.array([position]), np.eye(2)[None] * sigma**2, slow, speed)


def test_process_noise_of_two_seconds_by_hand():
    # q² = 0.01: q² t³/3 = 0.026667, q² t²/2 = 0.02, q² t = 0.02
    noise = kalman.process_noise(2.0, 0.1)
    assert noise[0] == pytest.approx([0.08 / 3.0, 0.0, 0.02, 0.0])
    assert noise[3] == pytest.approx([0.0, 0.02, 0.0, 0.02])


@settings(max_examples=50, deadline=None)
@given(st.floats(0.0, 50.0), st.floats(0.0, 50.0), st.floats(0.0, 2.0))
def test_two_steps_are_one_long_step(first, second, acceleration):
    start = kalman.Beliefs(
        np.array([[1.0, -2.0, 0.3, 0.1]]),
        np.diag([0.5, 0.4, 0.2, 0.1])[None],
        np.random.default_rng(3).normal(size=(1, 4, kalman.SLOW_COUNT)),
    )
    once = kalman.predict(start, first + second, acceleration)
    twice = kalman.predict(kalman.predict(start, first, acceleration), second, acceleration)
    assert twice.mean == pytest.approx(once.mean)
    assert twice.covariance == pytest.approx(once.covariance, rel=1e-9, abs=1e-12)
    assert twice.sensitivity == pytest.approx(once.sensitivity)


def test_without_acceleration_it_is_the_batch_least_squares_line():
    rng = np.random.default_rng(5)
    times = np.array([0.0, 0.4, 1.1, 1.5, 2.7])
    sigmas = np.array([0.5, 0.2, 0.3, 0.4, 0.1])
    measured = rng.normal(size=(len(times), 2))
    belief = _one(measured[0], sigmas[0], speed=10.0)
    for i in range(1, len(times)):
        belief = kalman.predict(belief, times[i] - times[i - 1], 0.0)
        white = np.eye(2)[None] * sigmas[i] ** 2
        belief = kalman.correct(belief, measured[i][None], white, NO_SLOW, NO_DRIFT)
    # the same as one weighted problem in (position at the end, velocity), prior on the velocity
    rows = np.column_stack([np.ones(len(times)), times - times[-1]]) / sigmas[:, None]
    rows = np.vstack([rows, [0.0, 1.0 / 10.0]])
    right = np.vstack([measured / sigmas[:, None], np.zeros((1, 2))])
    line = np.linalg.lstsq(rows, right, rcond=None)[0]
    assert belief.mean[0] == pytest.approx(np.concatenate([line[0], line[1]]), abs=1e-9)
    information = rows.T @ rows
    assert belief.covariance[0][::2, ::2] == pytest.approx(np.linalg.inv(information), abs=1e-9)


def test_a_new_geometry_moves_the_state_without_faking_a_speed():
    """Seen from the other side the same compass error shows the other way: 5 m, not 5 m a tick."""
    slow = np.zeros((1, 2, kalman.SLOW_COUNT))
    slow[0, 0, 0] = 2.5
    belief = _one(sigma=0.1, speed=0.1, slow=slow)
    for _ in range(50):
        belief = kalman.predict(belief, 0.1, 0.05)
        belief = kalman.correct(belief, np.zeros((1, 2)), np.eye(2)[None] * 0.01, slow, NO_DRIFT)
    there = np.array([[-5.0, 0.0]])
    after = kalman.correct(belief, there, np.eye(2)[None] * 0.01, -slow, NO_DRIFT)
    assert after.mean[0, 0] == pytest.approx(-5.0, abs=0.05)
    assert abs(after.mean[0, 2]) < 0.05
    assert after.sensitivity[0, 0, 0] == pytest.approx(-2.5, abs=0.05)


def _flight(bias, seed):
    """Return the belief after 40 images from a place that goes round, with a bias and noise."""
    rng = np.random.default_rng(seed)
    belief = None
    for i in range(40):
        angle = 0.1 * i
        slow = np.zeros((1, 2, kalman.SLOW_COUNT))
        slow[0, :, 0] = 1.2, 0.0
        slow[0, :, 1] = 2.0 * np.cos(angle), 2.0 * np.sin(angle)
        measured = (rng.normal(0.0, 0.1, 2) + slow[0] @ bias)[None]
        white = np.eye(2)[None] * 0.01
        if belief is None:
            belief = kalman.begin(measured, white, slow, 0.75)
        else:
            belief = kalman.predict(belief, 0.2, 0.05)
            belief = kalman.correct(belief, measured, white, slow, NO_DRIFT)
    return belief


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-3.0, 3.0), min_size=kalman.SLOW_COUNT, max_size=kalman.SLOW_COUNT))
def test_the_sensitivity_is_what_a_bias_really_does_to_the_state(bias):
    bias = np.array(bias)
    clean, biased = _flight(np.zeros(kalman.SLOW_COUNT), 1), _flight(bias, 1)
    assert biased.mean[0] - clean.mean[0] == pytest.approx(clean.sensitivity[0] @ bias, abs=1e-9)


def test_published_covariance_fits_the_errors_of_many_flights():
    rng = np.random.default_rng(7)
    last = [_flight(rng.normal(size=kalman.SLOW_COUNT), seed) for seed in range(400)]
    errors = np.array([belief.mean[0] for belief in last])
    total = last[0].total_covariance[0]
    # the robot stands still, but the filter allows for its motion: errors are a little smaller
    ratio = np.einsum("ni,ij,nj->n", errors, np.linalg.inv(total), errors).mean() / 4.0
    assert 0.4 < ratio < 1.1
    assert errors[:, :2].std(axis=0) == pytest.approx(np.sqrt(np.diag(total)[:2]), rel=0.12)
    assert np.sqrt(np.diag(last[0].covariance[0])[:2]).max() < 0.1  # white noise alone: not honest


def test_the_covariance_never_falls_below_the_slow_share():
    slow = np.zeros((1, 2, kalman.SLOW_COUNT))
    slow[0, 0, 0] = slow[0, 1, 1] = 1.2
    belief = _one(sigma=0.1, slow=slow)
    for _ in range(2000):
        belief = kalman.predict(belief, 0.1, 0.05)
        belief = kalman.correct(belief, np.zeros((1, 2)), np.eye(2)[None] * 0.01, slow, NO_DRIFT)
    sigma = np.sqrt(np.diag(belief.total_covariance[0])[:2])
    assert (sigma >= 1.2).all()
    assert (sigma < 1.25).all()


@pytest.mark.parametrize(
    ("seconds", "tau", "share"),
    [(0.0, 300.0, 0.0), (1.0, 300.0, 0.0066445), (300.0, 300.0, 0.8646647), (5.0, 0.0, 1.0)],
)
def test_drift_of_a_gauss_markov_error(seconds, tau, share):
    slow = np.zeros((1, 2, kalman.SLOW_COUNT))
    slow[0, 0, 0] = 2.0
    drift = kalman.slow_drift(_one(slow=slow), np.array([seconds]), tau)
    assert drift[0] == pytest.approx(np.array([[4.0 * share, 0.0], [0.0, 0.0]]), rel=1e-5)


def test_an_unseen_robot_forgets_its_velocity() -> None:
    """Steps compose; after long the velocity has the given sigma, the path that of diffusion."""
    known = kalman.begin(np.zeros((1, 2)), np.zeros((1, 2, 2)), np.zeros((1, 2, 6)), 0.1)
    known = kalman.Beliefs(np.array([[0.0, 0.0, 0.6, 0.0]]), known.covariance, known.sensitivity)
    at_once = kalman.wander(known, 6.0, 0.75, 3.0)
    stepwise = known
    for _ in range(60):
        stepwise = kalman.wander(stepwise, 0.1, 0.75, 3.0)
    np.testing.assert_allclose(stepwise.covariance, at_once.covariance, atol=1e-12)
    np.testing.assert_allclose(at_once.mean[0], [1.8 * (1 - np.exp(-2)), 0, 0.6 * np.exp(-2), 0])
    late = kalman.wander(known, 3000.0, 0.75, 3.0)
    assert late.covariance[0, 2, 2] == pytest.approx(0.75**2)
    assert late.covariance[0, 0, 0] == pytest.approx(2 * 0.75**2 * 3.0 * 3000.0, rel=2e-3)
