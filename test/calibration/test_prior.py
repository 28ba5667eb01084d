# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The precision before the data, against its own determinant and the noise set."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.calibration.layout import Layout
from aerial_gnss_ros.calibration.pose_errors import ERRORS
from aerial_gnss_ros.calibration.prior import Prior
from aerial_gnss_ros.calibration.unknowns import DRIFT, FIRST_ROBOT, POINTING
from aerial_gnss_ros.core.config.noise import Noise

SIGMAS = np.array([1e-3, 0.5, 0.2, 0.01])


@pytest.fixture(name="layout")
def _layout() -> Layout:
    t = np.repeat(np.linspace(0.0, 12.0, 13), 2)
    return Layout(t, np.tile([0, 1], 13), 1.0, dict.fromkeys(ERRORS, 2.0), np.ones((26, 3)))


def test_determinant(layout) -> None:
    assert layout.processes == FIRST_ROBOT + 2
    matrix, log_det = Prior(layout, Noise()).precision(SIGMAS)
    assert log_det == pytest.approx(np.linalg.slogdet(matrix.toarray())[1], abs=1e-3)


def test_processes_have_their_sigmas(layout) -> None:
    prior = Prior(layout, Noise(heading_deg=3.0))
    covariance = np.linalg.inv(prior.precision(SIGMAS)[0].toarray())
    sigma = np.sqrt(np.diag(covariance))
    heading = layout.first_drift[ERRORS.index("heading")]
    np.testing.assert_allclose(np.degrees(sigma[heading : heading + layout.drifts[5].count]), 3.0)
    columns, part = prior.part(POINTING)
    np.testing.assert_allclose(sigma[columns], 1e-3)
    own = part.toarray()[np.ix_(columns, columns)]
    np.testing.assert_allclose(np.diag(np.linalg.inv(own)), 1.0)
    drifts, _ = prior.part(DRIFT)
    assert drifts[0] == layout.first_drift[0]
    assert drifts[-1] == layout.first_pointing - 1
