# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One turn of the camera, or robots that manoeuvre: which explains changes of velocity better."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.rotation_test import TUNING as ROTATION_TEST
from aerial_gnss_ros.core.faults.rotation_test import fit_rotation
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.measurement_model import pose_jacobian

STATED = 0.06**2
"""Variance of a change of velocity in some seconds, by 0.05 m/s^1.5 over 3 s / 2."""
PLACES = np.array([[4.0, 18.0, -30.0], [-6.0, 22.0, -30.0], [1.0, 30.0, -30.0]])
BY_ANGLES = pose_jacobian(PLACES)[:, :, 3:]
SWERVES = ROTATION_TEST.swerve_share * 1.5


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_robots_that_all_move_as_one_turn_would_have_it_are_a_turn(axis):
    turn = np.radians(2.0) * np.eye(3)[axis]
    found, spread, gain = fit_rotation(-BY_ANGLES @ turn, np.full(3, STATED), BY_ANGLES, SWERVES)
    assert found == pytest.approx(turn, abs=math.radians(0.05))  # drawn a little to none
    assert gain > 2.0 * CLEAR_NATS
    # 0.06 m/s at 36 m is 0.1 deg/s; three robots measure it somewhat better
    assert 0.03 < math.degrees(math.sqrt(spread[0, 0])) < 0.1


@pytest.mark.parametrize("count", [1, 2, 3])
def test_robots_that_obey_are_no_turn(count):
    """50 000 seconds' worth: none by chance."""
    rng = np.random.default_rng(count)
    most = max(
        fit_rotation(sums, np.full(count, STATED), BY_ANGLES[:count], SWERVES)[2]
        for sums in 0.06 * rng.standard_normal((5000, count, 2))
    )
    assert most < CLEAR_NATS - 3.0


def test_robots_that_swerve_each_by_itself_are_no_turn():
    changes = np.array([[0.7, 0.0], [-0.3, 0.5], [0.0, -0.6]])
    assert fit_rotation(changes, np.full(3, STATED), BY_ANGLES, SWERVES)[2] < 0.0
    one = np.array([[0.7, 0.3], [0.0, 0.02], [-0.03, 0.0]])
    assert fit_rotation(one, np.full(3, STATED), BY_ANGLES, SWERVES)[2] < 0.0


@pytest.mark.parametrize(("speed", "turns"), [(0.6, False), (1.6, True)])
def test_of_one_robot_alone_only_its_speed_tells(speed, turns):
    gain = fit_rotation(np.array([[0.0, speed]]), np.full(1, STATED), BY_ANGLES[:1], SWERVES)[2]
    assert (gain > CLEAR_NATS) is turns


@pytest.mark.parametrize("height", [10.0, 30.0])
@pytest.mark.parametrize("axis", [0, 2], ids=["pitch", "yaw"])
@pytest.mark.parametrize(
    ("count", "least", "most"), [(1, 1.1, 1.45), (2, 0.45, 0.9), (3, 0.15, 0.3)]
)
def test_the_least_turn_that_is_detected(count, least, most, axis, height):
    """The least velocity change that is noticed, m/s, as docs/explanation/failures.md states it."""
    share = np.random.default_rng(1).uniform([-0.4, 0.4], [0.4, 1.0], (count, 2))
    places = height * np.column_stack([share, -np.ones(count)])
    by_angles = pose_jacobian(places)[:, :, 3:]
    for speed in np.arange(0.05, 3.0, 0.05):
        moved = -by_angles[:, :, axis]
        moved *= speed / np.linalg.norm(moved, axis=1).mean()
        if fit_rotation(moved, np.full(count, STATED), by_angles, SWERVES)[2] > CLEAR_NATS:
            break
    assert least <= speed <= most


def test_the_gain_is_that_of_the_formula():
    """Of one robot and no swerve: two normal laws, and what is unknown of the turn (Laplace)."""
    sums, variance = np.array([[0.3, -0.2]]), 0.04
    by_angles, prior = BY_ANGLES[:1], np.radians(5.0) ** 2 * np.eye(3)
    _, spread, gain = fit_rotation(sums, np.array([variance]), by_angles, 1e-9)
    each = variance * np.eye(2)
    both = each + by_angles[0] @ prior @ by_angles[0].T
    squares = [float(sums[0] @ np.linalg.solve(law, sums[0])) for law in (each, both)]
    ratio = np.log(np.linalg.det(both) / np.linalg.det(each))
    # A swerve without a sigma changes no square and costs log 4: it is never the cheaper one.
    assert gain == pytest.approx(0.5 * (squares[0] - squares[1]) - 0.5 * ratio)
    known = np.linalg.inv(prior) + by_angles[0].T @ by_angles[0] / variance
    np.testing.assert_allclose(spread, np.linalg.inv(known))
