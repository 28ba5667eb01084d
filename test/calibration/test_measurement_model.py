# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes as a function of all unknowns: derivatives against differences."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.problem import Problem
from aerial_gnss_ros.calibration.unknowns import FIX_DELAY, FOCAL, LATENCY

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record

STEP = 1e-5


@pytest.fixture(scope="module")
def linked():
    """Return the model of a short flight over two robots, and where its unknowns begin."""
    made = experiment("transit", 0.0, 2, swims=True, duration_s=15.0)
    recording = record(made)
    found = Problem(recording, Motion(recording), 30).evidence(0.1, 0.0, 0.2)
    rng = np.random.default_rng(1)
    unknowns = found.state.unknowns + 1e-3 * rng.standard_normal(len(found.state.unknowns))
    return found.evidence.model, unknowns


def differences(model, unknowns, way):
    """Return how the residuals change along a way through the unknowns, (2 n,)."""
    ahead, back = (model.predicted(unknowns + sign * STEP * way).values for sign in (1.0, -1.0))
    return (np.nan_to_num(back - ahead) / (2.0 * STEP)).ravel()


def test_the_jacobian_is_that_of_the_prediction_along_any_way(linked):
    model, unknowns = linked
    table = model.jacobian(model.predicted(unknowns), np.ones(len(model.tracks)))
    rng = np.random.default_rng(2)
    for _ in range(5):
        way = rng.standard_normal(len(unknowns))
        way[[LATENCY, FIX_DELAY]] = 0.0  # of splines, whose derivative is that of the motion
        expected = differences(model, unknowns, way)
        assert np.linalg.norm(table @ way - expected) < 0.01 * np.linalg.norm(expected)


@pytest.mark.parametrize("column", [LATENCY, FIX_DELAY, FOCAL])
def test_the_jacobian_by_delays_and_focal_length_is_that_of_the_prediction(linked, column):
    model, unknowns = linked
    table = model.jacobian(model.predicted(unknowns), np.ones(len(model.tracks)))
    way = np.eye(1, len(unknowns), column)[0]
    expected = differences(model, unknowns, way)
    assert np.linalg.norm(table @ way - expected) < 0.01 * np.linalg.norm(expected)


def test_each_box_has_its_weight(linked):
    model, unknowns = linked
    found, count = model.predicted(unknowns), len(model.tracks)
    plain = model.jacobian(found, np.ones(count)).toarray()
    weighted = model.jacobian(found, np.arange(count)).toarray()
    np.testing.assert_allclose(weighted, np.repeat(np.arange(count), 2)[:, None] * plain)


def test_forces_on_errors_are_forces_on_what_makes_them(linked):
    """The gradient is the adjoint of the errors, which are linear in the unknowns."""
    model, unknowns = linked
    rng = np.random.default_rng(3)
    force, way = rng.standard_normal((len(model.tracks), 6)), rng.standard_normal(len(unknowns))
    changed = model._errors(unknowns + way) - model._errors(unknowns)
    assert model.gradient_by_errors(force) @ way == pytest.approx(float(np.sum(force * changed)))
