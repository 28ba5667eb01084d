# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is known before the boxes: processes have the strength and the memory that they state."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.calibration.layout import (
    FIRST_ROBOT,
    VELOCITY_TIME_S,
    Hats,
    Layout,
    Path,
    _markov,
)
from aerial_gnss_ros.calibration.motion import ERRORS
from aerial_gnss_ros.core.config.noise import Noise


def test_hats_interpolate() -> None:
    t = np.array([0.0, 0.25, 1.0, 3.0])
    hats = Hats.of(t, 1.0, 100)
    assert hats.count == 4
    np.testing.assert_allclose(hats.table() @ np.array([0.0, 1.0, 2.0, 3.0]), t)


def test_a_drift_has_its_sigma_and_memory() -> None:
    chain, log_det = _markov(Hats.of(np.array([0.0, 30.0]), 10.0, 100), 20.0)
    covariance = np.linalg.inv(chain)
    np.testing.assert_allclose(np.diag(covariance), 1.0)
    assert covariance[0, 1] == pytest.approx(np.exp(-0.5))
    assert log_det == pytest.approx(np.linalg.slogdet(chain)[1])


def test_a_path_of_1_mps_moves_so() -> None:
    """Drawn paths have the velocity's sigma and correlation of an Ornstein-Uhlenbeck process."""
    t = np.linspace(0.0, 40.0, 81)
    path = Path.of(t, np.arange(len(t)))
    whole = path.rough + np.outer(path.middle, path.middle) / 300.0**2
    table = np.zeros((len(t), path.count))
    np.put_along_axis(table, path.columns, path.weights, axis=1)
    rate = np.diff(table, axis=0) / 0.5
    spread = rate @ np.linalg.inv(whole) @ rate.T
    assert np.sqrt(np.diag(spread)[10:-10]).mean() == pytest.approx(1.0, abs=0.1)
    late = spread[20, 20 + round(VELOCITY_TIME_S / 0.5)] / spread[20, 20]
    assert late == pytest.approx(np.exp(-1.0), abs=0.1)


def test_determinant_and_means() -> None:
    t = np.repeat(np.linspace(0.0, 12.0, 13), 2)
    tracks = np.tile([0, 1], 13)
    calm = dict.fromkeys(ERRORS, 2.0)
    layout = Layout(t, tracks, Noise(), 1.0, calm)
    strengths = np.array([1e-3, 0.5, 0.2, 0.01])
    assert layout.strengths == FIRST_ROBOT + 2
    matrix, log_det = layout.precision(strengths)
    assert log_det == pytest.approx(np.linalg.slogdet(matrix.toarray())[1], abs=1e-3)
    pick = layout.mean_of("height")
    assert pick.sum() == pytest.approx(2.0)  # the constant, and the drift's mean
    assert np.count_nonzero(pick) > 2
