# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inside, outside and in between, in an area whose distances are known by the geodesic."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod

from aerial_gnss_ros.core.georeferencing.area import OUTSIDE_SIGMAS, AreaOfOperation
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.values.rejection import Reason

GEOD = Geod(ellps="WGS84")
LONGITUDE, LATITUDE = 10.0, 54.0


def place(east, north):
    """Return longitude and latitude, degrees, of metres from the first corner."""
    longitude, latitude, _ = GEOD.fwd(
        LONGITUDE, LATITUDE, math.degrees(math.atan2(east, north)), math.hypot(east, north)
    )
    return longitude, latitude


def ring(*corners):
    return np.array([place(*corner) for corner in corners])


SQUARE = ring((0, 0), (100, 0), (100, 100), (0, 100))
HOLE = ring((40, 40), (40, 60), (60, 60), (60, 40))
AREA = AreaOfOperation(((SQUARE, HOLE), (ring((200, 0), (300, 0), (200, 100)),)))


def points(metres, sigma=(1.0, 1.0), reasons=None):
    longitude, latitude = np.radians([place(*one) for one in metres]).T
    count = len(metres)
    half = 0.5 * np.tile(np.diag(np.square(sigma)), (count, 1, 1))
    nothing = np.zeros((count, 2))
    return WaterPoints(
        latitude, longitude, 0.0, nothing, np.ones(count), half, half, nothing,
        reasons or (None,) * count,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("metres", "distance"),
    [
        ((50, 20), 0),
        ((50, 50), 10),  # in the middle of the hole
        ((50, 57), 3),
        ((104, 50), 4),
        ((103, 104), 5),  # off a corner
        ((-7, 50), 7),
        ((50, -6), 6),
        ((50, 108), 8),
        ((220, 20), 0),
        ((260, 60), 20 / math.sqrt(2)),  # off the slanting edge
        ((190, 50), 10),
    ],
)
def test_the_distance_to_the_nearest_edge(metres, distance):
    longitude, latitude = np.radians(place(*metres))
    assert AREA.distance(latitude, longitude) == pytest.approx(distance, abs=0.01)


def test_outside_is_what_is_so_beyond_its_uncertainty_towards_the_edge():
    near, far = OUTSIDE_SIGMAS - 0.05, OUTSIDE_SIGMAS + 0.05
    cases = points([(100 + near, 50), (100 + far, 50), (50, 100 + 2 * near), (50, 100 + 2 * far)])
    assert AREA.outside(cases).tolist() == [False, True, True, True]
    cases = points([(100 + near, 50), (100 + far, 50), (50, 100 + 2 * near), (50, 100 + 2 * far)],
                   sigma=(1.0, 2.0))  # fmt: skip
    assert AREA.outside(cases).tolist() == [False, True, False, True]


def test_a_refused_point_is_not_refused_again():
    cases = points([(500, 500), (500, 500)], reasons=(Reason.ABOVE_HORIZON, None))
    assert AREA.outside(cases).tolist() == [False, True]
    cases = points([(500, 500)], reasons=(Reason.ABOVE_HORIZON,))
    assert AREA.outside(cases).tolist() == [False]


@given(st.floats(-50, 150), st.floats(-50, 150))
def test_a_square_is_what_its_sides_say(east, north):
    beyond = np.maximum(np.abs(np.array([east, north]) - 50.0) - 50.0, 0.0)
    longitude, latitude = np.radians(place(east, north))
    area = AreaOfOperation(((SQUARE,),))
    assert area.distance(latitude, longitude) == pytest.approx(math.hypot(*beyond), abs=0.01)
