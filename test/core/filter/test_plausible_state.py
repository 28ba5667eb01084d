# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""States that cannot be, and those that just can."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.plausible_state import (
    check_covariance,
    check_estimates,
    check_robots,
)
from aerial_gnss_ros.core.values.errors import StateError
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State

FIRST = RobotEstimate(
    0, "aqua_1", "aqua", State.CONFIRMED, 0.2, -1.0, math.nan, np.zeros(2), np.zeros(2),
    np.diag([1.0, 1.0, 0.0, 0.0]), 0,
)  # fmt: skip
SECOND = replace(FIRST, robot_id="aqua_2")


@pytest.mark.parametrize("size", [7, 11])
def test_covariances_that_cannot_be(size):
    good = np.eye(size) * 4.0
    good[0, 1] = good[1, 0] = 1.0
    check_covariance(good, "robots")
    check_covariance(good * (1.0 + 1e-12 * np.arange(size)), "robots")  # rounding
    for row, column, value, words in (
        (2, 2, -1e-9, "variance"),
        (0, 3, 1e-3, "symmetric"),
        (1, 1, math.inf, "finite"),
        (1, 2, math.nan, "finite"),
    ):
        bad = good.copy()
        bad[row, column] = value
        with pytest.raises(StateError, match=words):
            check_covariance(bad, "robots")


@pytest.mark.parametrize(
    "change",
    [
        {"latitude": math.nan},
        {"longitude": -math.inf},
        {"covariance": np.diag([0.0, 1.0, 1.0, 1.0])},
        {"covariance": np.diag([1.0, -1.0, 1.0, 1.0])},
        {"covariance": np.diag([1.0, 1.0, 1.0, -1.0])},
        {"covariance": np.full((4, 4), math.nan)},
    ],
    ids=str,
)
def test_estimates_that_cannot_be(change):
    check_estimates(())
    check_estimates([FIRST, SECOND])
    bad = replace(FIRST, **change)
    for estimates in ((bad, SECOND), (SECOND, bad)):
        with pytest.raises(StateError, match="aqua_1 would be published"):
            check_estimates(estimates)


def test_robots_that_cannot_be():
    check_robots(np.array([[1e6, -1e6, 1e3, -1e3]]), "robots")
    check_robots(np.zeros((0, 4)), "robots")
    for bad in ([1.1e6, 0, 0, 0], [0, -1.1e6, 0, 0], [0, 0, -1.1e3, 0], [0, 0, 0, math.nan]):
        with pytest.raises(StateError):
            check_robots(np.array([[0.0] * 4, bad]), "robots")
