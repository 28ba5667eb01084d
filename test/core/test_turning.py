# SPDX-License-Identifier: Apache-2.0
"""A camera that turns by itself is told from robots that swim, or the doubt is published."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.joint_geometry import pose_jacobian
from aerial_gnss_ros.core.turning import BEGINS, MOST, SWERVE, Turning, explained
from aerial_gnss_ros.core.values import State

STATED = 0.06**2
"""Variance of a change of velocity in some seconds, by 0.05 m/s^1.5 over 3 s / 2."""
PLACES = np.array([[4.0, 18.0, -30.0], [-6.0, 22.0, -30.0], [1.0, 30.0, -30.0]])
BY_ANGLES = pose_jacobian(PLACES)[:, :, 3:]
SWERVES = SWERVE * 1.5


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_robots_that_all_move_as_one_turn_would_have_it_are_a_turn(axis):
    turn = np.radians(2.0) * np.eye(3)[axis]
    found, spread, gain = explained(-BY_ANGLES @ turn, np.full(3, STATED), BY_ANGLES, SWERVES)
    assert found == pytest.approx(turn, abs=math.radians(0.05))  # drawn a little to none
    assert gain > 2.0 * BEGINS
    # 0.06 m/s at 36 m is 0.1 deg/s; three robots tell it somewhat better
    assert 0.03 < math.degrees(math.sqrt(spread[0, 0])) < 0.1


@pytest.mark.parametrize("count", [1, 2, 3])
def test_robots_that_obey_are_no_turn(count):
    """50 000 seconds' worth: none by chance."""
    rng = np.random.default_rng(count)
    most = max(
        explained(sums, np.full(count, STATED), BY_ANGLES[:count], SWERVES)[2]
        for sums in 0.06 * rng.standard_normal((5000, count, 2))
    )
    assert most < BEGINS - 3.0


def test_robots_that_swerve_each_by_itself_are_no_turn():
    changes = np.array([[0.7, 0.0], [-0.3, 0.5], [0.0, -0.6]])
    assert explained(changes, np.full(3, STATED), BY_ANGLES, SWERVES)[2] < 0.0
    one = np.array([[0.7, 0.3], [0.0, 0.02], [-0.03, 0.0]])
    assert explained(one, np.full(3, STATED), BY_ANGLES, SWERVES)[2] < 0.0


@pytest.mark.parametrize(("speed", "turns"), [(0.6, False), (1.6, True)])
def test_of_one_robot_alone_only_its_speed_tells(speed, turns):
    gain = explained(np.array([[0.0, speed]]), np.full(1, STATED), BY_ANGLES[:1], SWERVES)[2]
    assert (gain > BEGINS) is turns


@pytest.mark.parametrize("height", [10.0, 30.0])
@pytest.mark.parametrize("axis", [0, 2], ids=["pitch", "yaw"])
@pytest.mark.parametrize(
    ("count", "least", "most"), [(1, 1.2, 1.55), (2, 0.45, 1.0), (3, 0.15, 0.45)]
)
def test_the_least_turn_that_is_told(count, least, most, axis, height):
    """How fast it makes robots seem, m/s: what docs/estimation.md says of what cannot be told."""
    share = np.random.default_rng(1).uniform([-0.4, 0.4], [0.4, 1.0], (count, 2))
    places = height * np.column_stack([share, -np.ones(count)])
    by_angles = pose_jacobian(places)[:, :, 3:]
    for speed in np.arange(0.05, 3.0, 0.05):
        moved = -by_angles[:, :, axis]
        moved *= speed / np.linalg.norm(moved, axis=1).mean()
        if explained(moved, np.full(count, STATED), by_angles, SWERVES)[2] > BEGINS:
            break
    assert least <= speed <= most


def test_boxes_that_nobody_explains_make_the_angle_unknown_until_robots_are_back():
    turning = Turning()
    turning.lost(0.5)
    turning.lost(0.5)
    # 20 deg/s for a second and what was not noticed at first
    assert np.sqrt(np.diag(turning.doubt)) == pytest.approx(math.radians(26.0))
    for _ in range(10):
        turning.lost(0.5)
    assert np.sqrt(np.diag(turning.doubt)) == pytest.approx(MOST)
    turning.lost(0.0, over=True)
    assert not turning.doubt.any()
    turning.lost(0.1)
    turning.lost(0.0)  # one image
    assert not turning.doubt.any()
    turning.lost(0.5)
    turning.lost(0.5)
    turning.lost(0.0)  # others than before, or elsewhere
    assert turning.doubt.any()


ROBOTS = {
    "a": lambda _t: (2.0, 21.0),
    "b": lambda t: (-3.0 + 0.2 * t, 14.0),
    "c": lambda t: (-6.0, 24.0 - 0.1 * t),
}


def _squares(world, results, sea, of):
    """Return squared normalised errors of robots in sight, and their sigmas (m)."""
    squares, sigmas = [], []
    for result in results:
        t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
        for one in result.estimates:
            if one.state is State.CONFIRMED:
                error = one.position - world.robots[of[one.robot_id]](t)
                squares.append(error @ np.linalg.solve(one.covariance[:2, :2], error))
                sigmas.append(math.sqrt(0.5 * np.trace(one.covariance[:2, :2])))
    return np.array(squares), np.array(sigmas)


@pytest.mark.parametrize("axis", [1, 2], ids=["pitch", "yaw"])
def test_a_runaway_slower_than_robots_is_published_as_doubt(sea, axis):
    """2 deg/s for 8 s at 34 m is some 10 m: robots seem to swim, and nobody can say it is wrong."""
    world = sea.World(robots=ROBOTS, pixel_sigma=1.5)
    engine = sea.estimator({"noise.gnss_offset_m": 0.02})
    before = sea.play(engine, world, 8.0, until_flush=False)
    of = {
        e.robot_id: min(ROBOTS, key=lambda name: np.linalg.norm(e.position - ROBOTS[name](8.0)))
        for e in before[-1].estimates
    }
    assert not engine.health.complaints
    calm = _squares(world, before[20:], sea, of)[1].max()
    parts = {}
    for name, begin, length, angle in (
        ("runs", 8.2, 40, lambda i: 0.4 * i),
        ("back", 16.2, 40, lambda i: 16.0 - 0.4 * i),
        ("right", 24.2, 20, lambda _i: 0.0),
    ):
        parts[name] = []
        for i in range(length):
            bias = [0.0, 0.0, 0.0]
            bias[axis] = angle(i)
            world.rpy_bias_deg = tuple(bias)
            parts[name] += sea.play(engine, world, 0.1, begin=begin + 0.2 * i, until_flush=False)
        squares, sigmas = _squares(world, parts[name], sea, of)
        assert np.quantile(squares, 0.98) < 13.8  # one in a thousand, if the covariance is right
        parts[name] = sigmas
    assert any("turned by itself" in sentence for sentence in engine.health.complaints)
    assert parts["runs"][-3:].min() > 2.0  # m
    assert calm < parts["right"][-1] < 0.8 * parts["runs"].max()  # the way back takes some away
