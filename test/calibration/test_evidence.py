# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The likelihood of boxes, against dense algebra and finite differences."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.calibration.evidence import FIRST_DAMPING, HELD
from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.problem import Problem
from aerial_gnss_ros.calibration.unknowns import (
    BOX,
    CONSTANTS,
    FIRST_ERROR,
    FIX_DELAY,
    FOCAL,
    LATENCY,
    POINTING,
    PRIOR_SIGMAS,
)

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record


@pytest.fixture(scope="module")
def linked():
    recording = record(experiment("orbit", 0.0, 5))
    found = Problem(recording, Motion(recording), 12).evidence(0.0, 0.0)
    assert found is not None
    sigmas = np.full(found.evidence.model.layout.processes, 0.3)
    sigmas[POINTING], sigmas[BOX] = 1e-3, 0.5
    layout = found.evidence.model.layout
    layout.pointing_weights[1] *= 3.0  # interpolation may err differently about each axis
    return found.evidence, replace(found.state, sigmas=sigmas, pixel=2.0)


def _dense(evidence, state):
    """Jacobian by finite differences, and the prior."""
    x = state.unknowns
    values = evidence.model.predicted(x).values
    jacobian = np.zeros((values.size, len(x)))
    for column in range(len(x)):
        step = np.zeros(len(x))
        step[column] = 1e-5
        off = evidence.model.predicted(x + step).values - evidence.model.predicted(x - step).values
        jacobian[:, column] = -off.ravel() / 2e-5
    prior, log_det = evidence.prior.precision(state.sigmas)
    return values.ravel(), jacobian, prior.toarray(), log_det


def test_derivatives_and_likelihood(linked) -> None:
    evidence, state = linked
    rng = np.random.default_rng(1)
    layout = evidence.model.layout
    unknowns = state.unknowns + np.where(np.arange(layout.size) > 2, 1e-3, 0.0) * rng.normal(
        size=layout.size
    )
    state = evidence.descend(replace(state, unknowns=unknowns), 8, frozenset({LATENCY}), False)
    values, jacobian, prior, log_det = _dense(evidence, state)
    assert np.all(state.distances < 2.5)  # no box counts less: the formula is exact
    nothing = 0.0 * evidence.prior.precision(state.sigmas)[0]
    there = evidence.model.predicted(state.unknowns)
    found = evidence._normal(state, there, nothing, frozenset())[0].toarray()
    expected = jacobian.T @ jacobian / state.pixel**2
    # Derivatives by the delays come from splines, the others are exact.
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected))) + 1e-9
    np.testing.assert_allclose(found / scale, expected / scale, atol=0.05)

    information = expected + prior
    information[LATENCY, LATENCY] += HELD
    cost = float(values @ values) / state.pixel**2 + float(state.unknowns @ prior @ state.unknowns)
    noise = len(values) * np.log(state.pixel * np.sqrt(2.0 * np.pi))
    log_det += np.log(HELD * PRIOR_SIGMAS[LATENCY] ** 2)
    by_hand = -0.5 * (cost + np.linalg.slogdet(information)[1] - log_det) - noise
    held = evidence.evaluated(state, frozenset({LATENCY}))
    assert held.log_likelihood == pytest.approx(by_hand, abs=0.05)
    pick = np.zeros((1, layout.size))
    pick[0, FIX_DELAY] = 1.0
    sigma2 = float(np.linalg.inv(information)[FIX_DELAY, FIX_DELAY])
    assert float(evidence.covariance(held, pick)[0, 0]) == pytest.approx(sigma2, rel=0.01)


def test_constants_follow_the_delays(linked) -> None:
    """How the best fit moves with a held delay, against fitting again beside it."""
    evidence, state = linked
    held = frozenset({LATENCY, FIX_DELAY})
    picks = evidence.model.layout.mean_of("heading")[None]
    state = evidence.descend(state, 10, held, False)
    slope = float(evidence.slopes(state, picks, [LATENCY], held)[0, 0])
    ends = []
    for late in (-0.02, 0.02):
        unknowns = state.unknowns.copy()
        unknowns[LATENCY] = late
        again = evidence.descend(replace(state, unknowns=unknowns), 10, held, False)
        ends.append(float(picks[0] @ again.unknowns))
    assert slope == pytest.approx((ends[1] - ends[0]) / 0.04, rel=0.3)


def test_areas(linked) -> None:
    """What a square metre covers, against the determinant of the projection."""
    evidence, state = linked
    first = evidence.model.predicted(state.unknowns)
    moved = state.unknowns.copy()
    moved[3] += 0.5  # m of height
    again = evidence.model.predicted(moved)
    for one in (first, again):
        by_hand = np.log(np.abs(np.linalg.det(one.by_place)))
        off = by_hand - one.area
        assert np.ptp(off) < 0.5  # what remains is of the place in the image
    np.testing.assert_allclose(again.area - first.area, 0.5 * first.area_by_error[:, 2], atol=0.2)


@pytest.mark.parametrize("swims", [False, True])
def test_height_and_tilt_that_are_hardly_known_do_not_run_away(swims) -> None:
    """Robots seen from one place, 8 m of height and 9 deg of pitch off: whole steps go astray."""
    recording = record(experiment("hover", 0.0, 1, swims=swims))
    found = Problem(recording, Motion(recording), 60).evidence(0.0, 0.0)
    assert found is not None
    held = frozenset({LATENCY, FIX_DELAY, FOCAL})
    near = found.evidence.descend(found.state, 3, held)
    best = found.evidence.descend(near, 10, held, False)
    unknowns = near.unknowns.copy()
    unknowns[FIRST_ERROR + CONSTANTS.index("height")] += 8.0
    unknowns[FIRST_ERROR + CONSTANTS.index("gimbal_pitch")] += 0.16
    damped, whole = (
        found.evidence.descend(replace(near, unknowns=unknowns, damping=one), 2, held, False)
        for one in (FIRST_DAMPING, 0.0)
    )
    assert whole.cost > best.cost + 500.0
    assert damped.cost < best.cost + 50.0
    assert found.evidence.descend(damped, 10, held, False).cost < best.cost + 1.0
