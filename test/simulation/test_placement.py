# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots are placed where the camera sees them for most of the flight."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.simulation.experiment import default_camera
from aerial_gnss_ros.simulation.flight import Motion
from aerial_gnss_ros.simulation.placement import MARGIN, place_robots, seen_places, view_width

CAMERA = default_camera(1280, 720)


class Looking:
    """A flight to the east at 20 m, the camera so far below the horizon, ahead."""

    duration_s = 10.0

    def __init__(self, down_deg, speed=0.0):
        self._down, self._speed = np.radians(down_deg), speed

    def sample(self, t):
        t = np.atleast_1d(t)
        place = np.column_stack([self._speed * t, 0.0 * t, np.full(len(t), 20.0)])
        turn = np.tile(matrix_from_rpy(0.0, self._down, 0.0), (len(t), 1, 1))
        return Motion(t, place, place, np.tile(np.eye(3), (len(t), 1, 1)), turn)


def inside(flight, places):
    """Return the share (n,) of the flight for which places are in the inner image."""
    motion, found = flight.sample(np.linspace(0.0, 10.0, 50)), []
    size = np.array([CAMERA.width, CAMERA.height])
    for position, turn in zip(motion.camera, motion.enu_from_camera, strict=True):
        points = np.column_stack([places, np.zeros(len(places))]) - position
        pixels, _ = CAMERA.project(points @ turn @ FLU_FROM_OPTICAL)
        edge = (MARGIN - 0.02) * size
        found.append(((pixels > edge) & (pixels < size - edge)).all(axis=1))
    return np.mean(found, axis=0)


@pytest.mark.parametrize(("down_deg", "speed"), [(50.0, 0.0), (60.0, 0.5), (90.0, 0.5)])
def test_robots_are_in_view_and_apart(down_deg, speed):
    flight = Looking(down_deg, speed)
    places = place_robots(flight, CAMERA, 4, np.random.default_rng(1))
    assert places.shape == (4, 2)
    assert min(np.hypot(*(a - b)) for a, b in combinations(places, 2)) >= 2.5
    assert inside(flight, places).min() > 0.6


def test_the_first_is_below_a_camera_that_looks_straight_down():
    places = place_robots(Looking(90.0, 2.0), CAMERA, 2, np.random.default_rng(1))
    assert places[0] == pytest.approx([10.0, 0.0], abs=1e-6)


def test_more_robots_than_there_is_room_for_are_closer():
    places = place_robots(Looking(60.0), CAMERA, 30, np.random.default_rng(1), apart_m=50.0)
    assert len(np.unique(places, axis=0)) == 30
    assert inside(Looking(60.0), places).min() > 0.6
    assert place_robots(Looking(60.0), CAMERA, 0, np.random.default_rng(1)).shape == (0, 2)


def test_places_are_of_chance_alone():
    one, again, other = (
        place_robots(Looking(60.0), CAMERA, 3, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert (one == again).all()
    assert (one != other).any()


def test_a_camera_that_sees_no_water_is_refused():
    with pytest.raises(InputError, match="--robot-at"):
        seen_places(Looking(-40.0), CAMERA, np.random.default_rng(1))


@pytest.mark.parametrize(("down_deg", "distance_m"), [(90.0, 20.0), (30.0, 40.0), (-10.0, 20.0)])
def test_the_width_of_the_view_is_that_at_its_middle(down_deg, distance_m):
    focal = float(CAMERA.K[0, 0])
    assert view_width(Looking(down_deg), CAMERA) == pytest.approx(distance_m * 1280.0 / focal)
