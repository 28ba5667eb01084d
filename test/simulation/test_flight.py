# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated flights go where the plan says and lean as a multicopter must."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import rpy_from_matrix
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.flight import DRAG_PER_S, GRAVITY, FlightPlan, GeneratedFlight

T = np.arange(0.0, 60.0, 0.1)


def axis_on_water(motion):
    forward = motion.enu_from_camera[:, :, 0]
    return motion.camera[:, :2] - motion.camera[:, 2:] / forward[:, 2:] * forward[:, :2]


def test_an_orbit_keeps_radius_speed_and_the_point_in_the_middle():
    flight = GeneratedFlight(
        FlightPlan(kind="orbit", height_m=20.0, stand_off_m=25.0, speed_mps=3.0), seed=1
    )
    motion = flight.sample(T)
    radius = np.hypot(*motion.camera[:, :2].T)
    np.testing.assert_allclose(radius, 25.0, atol=1.2)
    np.testing.assert_allclose(motion.camera[:, 2], 20.0, atol=0.6)
    angle = np.unwrap(np.arctan2(motion.camera[:, 1], motion.camera[:, 0]))
    assert abs(angle[-1] - angle[0]) == pytest.approx(3.0 * T[-1] / 25.0, abs=0.1)
    assert np.linalg.norm(axis_on_water(motion), axis=1).max() < 2.5
    nose = motion.enu_from_flu[:, :2, 0]
    inward = -motion.camera[:, :2] / radius[:, None]
    assert (np.sum(nose * inward, axis=1) > 0.98).all()


def test_the_body_leans_so_that_thrust_accelerates_it_against_gravity_and_air():
    """The lean of a circling drone: v²/r inwards, and drag against its airspeed (hand sum)."""
    plan = FlightPlan(kind="orbit", stand_off_m=20.0, speed_mps=4.0, wind_mps=0.0)
    motion = GeneratedFlight(plan, seed=2).sample(T)
    up = motion.enu_from_flu[:, :, 2].mean(axis=0)
    lean = np.degrees(np.arccos(motion.enu_from_flu[:, 2, 2]))
    expected = math.degrees(math.atan(math.hypot(4.0**2 / 20.0, DRAG_PER_S * 4.0) / GRAVITY))
    assert lean.mean() == pytest.approx(expected, abs=0.7)
    assert up[2] > 0.9
    inward = -motion.camera[:, :2] / 20.0
    assert (np.sum(motion.enu_from_flu[:, :2, 2] * inward, axis=1) > 0.03).all()


def test_a_transit_goes_to_and_fro_beside_the_point():
    plan = FlightPlan(kind="transit", stand_off_m=12.0, leg_m=60.0, speed_mps=4.0)
    motion = GeneratedFlight(plan, seed=3).sample(np.arange(0.0, 60.0, 0.1))
    distance = np.hypot(*motion.camera[:, :2].T)
    assert distance.min() == pytest.approx(12.0, abs=0.8)
    assert distance.max() == pytest.approx(math.hypot(12.0, 30.0), abs=1.0)
    velocity = np.gradient(motion.camera, 0.1, axis=0)
    assert np.median(np.linalg.norm(velocity, axis=1)) == pytest.approx(4.0, abs=0.7)


def test_a_steep_or_fixed_camera_holds_its_angle_under_the_horizon():
    for plan in (
        FlightPlan(tilt=math.radians(90.0)),
        FlightPlan(tilt=math.radians(40.0), track=False),
    ):
        motion = GeneratedFlight(plan, seed=4).sample(T)
        pitch = np.arcsin(-motion.enu_from_camera[:, 2, 0])
        np.testing.assert_allclose(pitch, plan.tilt, atol=math.radians(0.6))


def test_the_camera_sits_at_its_offset_in_the_leaning_body():
    plan = FlightPlan(kind="orbit", camera_offset_m=(0.2, 0.05, -0.1))
    motion = GeneratedFlight(plan, seed=5).sample(T)
    offset = np.einsum("nji,nj->ni", motion.enu_from_flu, motion.camera - motion.antenna)
    np.testing.assert_allclose(offset, np.tile([0.2, 0.05, -0.1], (len(T), 1)), atol=1e-9)


def test_motion_is_smooth_and_the_seed_decides():
    plan = FlightPlan(kind="transit")
    fine = GeneratedFlight(plan, seed=6).sample(np.arange(0.0, 60.0, 0.02))
    for matrices in (fine.enu_from_flu, fine.enu_from_camera):
        turn = np.einsum("nij,nik->njk", matrices[:-1], matrices[1:])
        assert np.degrees(np.abs(rpy_from_matrix(turn))).max() < 1.5  # 75 deg/s
    again = GeneratedFlight(plan, seed=6).sample(fine.t)
    other = GeneratedFlight(plan, seed=7).sample(fine.t)
    np.testing.assert_array_equal(again.enu_from_camera, fine.enu_from_camera)
    assert np.abs(other.camera - fine.camera).max() > 0.5


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"kind": "loop"}, "hover, orbit, transit, not 'loop'"),
        ({"height_m": -3.0}, "height must lie within 0.5 to 500 m, not -3"),
        ({"tilt": 0.0}, "tilt must lie within 5 to 90 deg"),
        ({"speed_mps": math.nan}, "speed"),
        ({"stand_off_m": -1.0}, "stand-off must lie within 0 to 5000 m, not -1"),
    ],
)
def test_an_impossible_plan_is_refused(wrong, words):
    with pytest.raises(ConfigError, match=words):
        FlightPlan(**wrong)
