# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Processes have the strength and the memory that they state."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.calibration.processes import (
    VELOCITY_TIME_S,
    LinearBasis,
    Path,
    gauss_markov,
)


def test_a_linear_basis_interpolates() -> None:
    t = np.array([0.0, 0.25, 1.0, 3.0])
    basis = LinearBasis.of(t, 1.0, 100)
    assert basis.count == 4
    np.testing.assert_allclose(basis.table() @ np.array([0.0, 1.0, 2.0, 3.0]), t)


def test_a_drift_has_its_sigma_and_memory() -> None:
    chain, log_det = gauss_markov(LinearBasis.of(np.array([0.0, 30.0]), 10.0, 100), 20.0)
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
