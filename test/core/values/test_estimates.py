# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is stated of a robot beside its numbers."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate, State


@pytest.mark.parametrize(
    ("position", "sigma"),
    [
        (np.diag([4.0, 1.0]), 2.0),
        (np.diag([1.0, 9.0]), 3.0),
        (np.array([[2.5, 1.5], [1.5, 2.5]]), 2.0),  # 1 and 4, at 45 deg
    ],
)
def test_sigma_is_the_larger_axis_of_the_ellipse(position, sigma):
    covariance = np.diag([0.0, 0.0, 100.0, 100.0])
    covariance[:2, :2] = position
    numbers = 0.0, 0.0, 0.0, np.zeros(2), np.zeros(2), covariance, 0
    assert RobotEstimate(0, "aqua_1", "aqua", State.CONFIRMED, *numbers).sigma == (
        pytest.approx(sigma)
    )


def test_errors_of_angles_are_known_as_such():
    names = "gnss_east", "gnss_north", "height", "roll", "pitch", "heading", "latency"
    angles = [name for name in names if PlatformError(name, 0.0, 1.0).is_angle]
    assert angles == ["roll", "pitch", "heading"]
