# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much a flight varied, on a square."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.calibration.excitation import excitation
from aerial_gnss_ros.calibration.motion import Poses

CORNERS = np.array([[0.0, 0.0, 10.0], [30.0, 0.0, 20.0], [30.0, 40.0, 30.0], [99.0, 99.0, 99.0]])


def poses():
    """Return three corners 3 m/s apart, and one where nothing is known."""
    return Poses(
        CORNERS,
        np.tile(np.eye(3), (4, 1, 1)),
        np.array([[3.0, 0, 0], [0, 4.0, 0], [0, 0, 5.0], [1e3, 0, 0]]),
        np.radians([[0, 0, 3.0], [4.0, 0, 0], [0, 5.0, 0], [1e3, 0, 0]]),
        np.array([True, True, True, False]),
    )


def test_way_speed_turning_and_heights_are_those_that_are_known():
    found = excitation(poses(), np.array([0]), np.array([0]), np.array([[10.0, 0.0]]))
    assert found.travelled_m == pytest.approx(70.0)
    assert found.speed_mps == pytest.approx(math.sqrt((9.0 + 16.0 + 25.0) / 3.0))
    assert found.turned_dps == pytest.approx(math.sqrt((9.0 + 16.0 + 25.0) / 3.0))
    assert found.heights_m == (10.0, 30.0)


def test_directions_are_of_one_robot_and_tilts_and_ranges_of_all():
    """The first is seen to the east, to the north and straight below, the second once, far off."""
    images = np.array([0, 0, 1, 2])
    robots = np.array([0, 0, 0, 1])
    places = np.array([[10.0, 0.1], [0.1, 10.0], [30.0 - 1e-9, 0.0], [30.0, -60.0]])
    found = excitation(poses(), images, robots, places)
    assert found.directions_deg == 30.0
    assert found.ranges_m == pytest.approx((0.0, 100.0), abs=1e-6)
    assert found.tilts_deg == pytest.approx((math.degrees(math.atan2(30.0, 100.0)), 90.0))
    assert len(found.lines()) == 2
    assert "one of them over a range of bearings of 30 deg" in found.lines()[1]
