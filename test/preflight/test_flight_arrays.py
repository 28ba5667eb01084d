# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A flight as arrays: places, courses and changes over two seconds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.samples import Fix
from aerial_gnss_ros.preflight.flight_arrays import (
    FAST,
    LAG,
    STEP_S,
    changes,
    correlation,
    courses,
    differences,
    flight_arrays,
)
from aerial_gnss_ros.preflight.flight_state import STEP_NS, FlightState

LATITUDE, LONGITUDE = 0.2, -1.0


def state(i, east=0.0, north=0.0, heading_deg=0.0, down_deg=60.0):
    """Return the state of a drone at a place, with its camera ahead."""
    latitude, longitude, _ = geodetic_from_enu(east, north, 0.0, LATITUDE, LONGITUDE, 0.0)
    yaw = 0.5 * math.pi - math.radians(heading_deg)
    camera = matrix_from_rpy(0.0, math.radians(down_deg), yaw)
    return FlightState(
        i * STEP_NS, Fix(i * STEP_NS, float(latitude), float(longitude), 30.0 + i),
        matrix_from_rpy(0.1, 0.0, yaw), 20.0 + i,
        CameraPose(i * STEP_NS, float(latitude), float(longitude), 0.0, 20.0, camera),
    )  # fmt: skip


def test_states_become_columns():
    flight = flight_arrays([state(0), FlightState(STEP_NS), state(2, 3.0, 4.0, 90.0, 30.0)])
    assert flight.east_north[[0, 2]].tolist() == pytest.approx(np.array([[0, 0], [3, 4]]), abs=1e-3)
    assert flight.altitude[[0, 2]].tolist() == [30.0, 32.0]
    assert flight.height[[0, 2]].tolist() == [20.0, 22.0]
    assert np.degrees(flight.nose[[0, 2]]) == pytest.approx([0.0, 90.0], abs=1e-9)
    assert np.degrees(flight.view[[0, 2]]) == pytest.approx([0.0, 90.0], abs=1e-9)
    assert np.degrees(flight.below[[0, 2]]) == pytest.approx([60.0, 30.0])
    assert flight.up[0, 2] == pytest.approx(math.cos(0.1))
    for column in (flight.altitude, flight.height, flight.nose, flight.view, flight.below):
        assert math.isnan(column[1])


def test_without_a_fix_nothing_is_known_of_places():
    flight = flight_arrays([FlightState(i * STEP_NS) for i in range(30)])
    assert np.isnan(flight.east_north).all()
    assert np.isnan(courses(flight)).all()


@pytest.mark.parametrize(("speed", "known"), [(1.01 * FAST, True), (0.99 * FAST, False)])
def test_a_course_is_known_where_the_drone_is_fast(speed, known):
    """To the south-east, by differences of a second to both sides."""
    way = speed * math.sqrt(0.5) * STEP_S
    flight = flight_arrays([state(i, way * i, -way * i) for i in range(15)])
    middle = courses(flight)[5:10]
    if known:
        assert np.degrees(middle) == pytest.approx([135.0] * 5, abs=0.01)
    else:
        assert np.isnan(middle).all()
    assert np.isnan(courses(flight)[:5]).all()
    assert np.isnan(courses(flight)[10:]).all()


def test_changes_are_over_two_seconds_and_angles_go_the_shorter_way():
    ramp = np.arange(LAG + 2.0)
    assert differences(ramp).tolist() == [LAG, LAG]
    angles = np.radians(170.0) + 0.1 * ramp  # beyond 180 deg they are wrapped
    wrapped = np.angle(np.exp(1j * angles))
    assert changes(wrapped) == pytest.approx([0.1 * LAG] * 2)
    for of in (differences, changes):
        assert len(of(ramp[:LAG])) == 0


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [([1, 2], [2, 4], 1.0), ([1, 2], [-1, -2], -1.0), ([1, 0], [0, 1], 0.0), ([0, 0], [1, 1], 0.0)],
)
def test_correlation_is_not_centred(a, b, expected):
    assert correlation(np.array(a, float), np.array(b, float)) == pytest.approx(expected)
