# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Noise and speeds come out of the data."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.problem import Problem
from aerial_gnss_ros.calibration.unknowns import FIRST_ROBOT, FIX_DELAY, FOCAL, LATENCY, POINTING

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record


@pytest.mark.parametrize(("swims", "least", "most"), [(False, 0.0, 0.01), (True, 0.03, 0.6)])
def test_speeds_and_noise_are_found(swims, least, most) -> None:
    recording = record(experiment("orbit", 0.0, 5, swims=swims))
    found = Problem(recording, Motion(recording), 60).evidence(0.0, 0.0)
    assert found is not None
    held = frozenset({LATENCY, FIX_DELAY, FOCAL})
    state = found.evidence.descend(found.state, 15, held)
    assert np.all(state.sigmas[FIRST_ROBOT:] > least)
    assert np.all(state.sigmas[FIRST_ROBOT:] < most)
    assert state.pixel == pytest.approx(2.0, rel=0.35)
    assert state.effective is not None
    assert np.all(state.effective > 0.0)
    assert float(state.effective.sum()) < 2.0 * len(state.distances)


def test_pointing_errors_once_near_nothing_grow_again() -> None:
    """Far from the truth everything is noise of boxes, and a fit that gets there starts so."""
    recording = record(experiment("transit", 0.0, 2, images_hz=4.0))
    found = Problem(recording, Motion(recording), 120).evidence(0.0, 0.0)
    assert found is not None
    held = frozenset({LATENCY, FIX_DELAY, FOCAL})
    truth = found.evidence.descend(found.state, 20, held)
    sigmas = truth.sigmas.copy()
    sigmas[POINTING] = 1e-5
    again = found.evidence.descend(replace(truth, sigmas=sigmas), 25, held)
    assert truth.sigmas[POINTING] > 3e-4
    assert again.sigmas[POINTING] == pytest.approx(truth.sigmas[POINTING], rel=0.3)
