# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A receiver that is wrong by 2 m east makes every robot wrong by 2 m east, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import Track
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.evaluation.errors import RobotErrors
from aerial_gnss_ros.evaluation.receiver import relative

ORIGIN = (math.radians(13.19), math.radians(-59.64), 0.0)


def _path(east: np.ndarray, north: np.ndarray, step_ns: int) -> Track:
    latitude, longitude, _ = geodetic_from_enu(east, north, np.zeros_like(east), *ORIGIN)
    stamps = 1_700_000_000_000_000_000 + np.arange(len(east), dtype=np.int64) * step_ns
    return Track(stamps, latitude, longitude)


def test_the_receivers_own_error_is_taken_out() -> None:
    t = np.arange(50.0)
    true = _path(3.0 * t, 0.0 * t, 20_000_000)
    coarse = np.arange(0.0, 49.0, 5.0)
    measured = _path(3.0 * coarse + 2.0, 0.0 * coarse + 0.1 * coarse, 100_000_000)
    stamps = true.stamps_ns[[0, 10, 22]]
    errors = np.array([[2.0, 0.5], [2.0, 1.5], [2.4, 2.2]])
    robot = RobotErrors("a", "aqua_1", stamps, errors, np.zeros(3), np.zeros(3), 1.0)
    found = relative([robot], measured, true)[0]
    assert np.isnan(found.nees).all()  # the published covariance is of the absolute error
    assert found.east_north == pytest.approx(
        np.array([[0.0, 0.5], [0.0, 0.5], [0.4, 0.0]]), abs=1e-4
    )
