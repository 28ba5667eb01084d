# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A position that jumps is believed when it has stayed, and at once when it is back."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.gnss_jump import GnssJumpDetector
from aerial_gnss_ros.core.values.events import Events

pytestmark = pytest.mark.flights


def fly(easts):
    """Positions each 0.1 s of a drone that hovers, but for jumps; the decision of each image."""
    jumps, place, reported = GnssJumpDetector(Events()), 0.0, []
    for east in easts:
        now = np.array([east, 0.0, 20.0])
        settled, jump = jumps.update(now, np.array([place, 0.0, 20.0]), 0.1)
        place += 0.0 if jump is None else jump[0]
        reported.append((settled, 0.0 if jump is None else float(jump[0]), jumps.returned))
    return reported


def test_a_jump_that_stays_is_believed_after_three_seconds():
    reported = fly([0.0] * 3 + [50.0] * 35)
    assert reported[:3] == [(True, 0.0, False)] * 3
    assert [settled for settled, _, _ in reported[3:33]] == [False] * 30
    assert reported[33] == (True, 50.0, False)
    assert reported[34:] == [(True, 0.0, False)] * 4


def test_the_way_back_is_believed_at_once():
    reported = fly([0.0] * 3 + [50.0] * 35 + [0.0] * 3)
    assert reported[38] == (True, -50.0, True)
    assert reported[39][:2] == (True, 0.0)


def test_another_jump_is_not_the_way_back():
    reported = fly([0.0] * 3 + [50.0] * 35 + [100.0] * 3)
    assert [settled for settled, _, _ in reported[38:]] == [False] * 3
    assert fly([0.0] * 3 + [50.0] * 5 + [0.0] * 3)[9] == (True, 0.0, False)


def test_it_says_when_positions_leave_and_how_far_they_are():
    jumps, reported = GnssJumpDetector(Events()), []
    for east, expected in [(0.0, 0.0), (50.0, 0.0), (50.0, 0.0)]:
        jumps.update(np.array([east, 0.0, 20.0]), np.array([expected, 0.0, 20.0]), 2.0)
        reported.append((jumps.began, float(jumps.believed[0])))
    jumps.update(np.array([50.0, 0.0, 20.0]), np.array([0.0, 0.0, 20.0]), 2.0)
    assert [*reported, float(jumps.believed[0])] == [(False, 0.0), (True, 0.0), (False, 0.0), 50.0]
    jumps.update(np.array([100.0, 0.0, 20.0]), np.array([50.0, 0.0, 20.0]), 2.0)
    assert not jumps.began  # they had left before
    assert jumps._log.counts["position_jumps"] == 2
    jumps.update(np.array([0.0, 0.0, 20.0]), np.array([50.0, 0.0, 20.0]), 2.0)
    assert jumps.returned
    assert not jumps.believed.any()


def test_a_smaller_jump_is_believed_at_once_where_robots_tell_of_it():
    def flown(east, back):
        jumps, place, reported = GnssJumpDetector(Events()), 0.0, []
        for i, at in enumerate([0.0] * 50 + [east] * 35 + [back] * 2):
            now, expected = np.array([at, 0.0, 20.0]), np.array([place, 0.0, 20.0])
            settled, jump = jumps.update(now, expected, 0.1, 1.0, [i == 50].pop)
            place += 0.0 if jump is None else jump[0]
            reported.append((settled, 0.0 if jump is None else float(jump[0])))
        return reported

    reported = flown(8.0, 0.5)
    assert reported[49:52] == [(True, 0.0), (True, 8.0), (True, 0.0)]
    assert reported[85:] == [(True, -7.5), (True, 0.0)]  # at once, without evidence from robots
    assert flown(8.0, 4.5)[85] == (True, 0.0)  # that is nearer to where it jumped to


def test_a_jump_of_less_than_half_a_metre_is_not_called_one_of_0_m():
    log = Events()
    jumps = GnssJumpDetector(log)
    for i, at in enumerate([0.0] * 300 + [0.44] * 2):
        now, expected = np.array([at, 0.0, 20.0]), np.array([0.44 * (i > 300), 0.0, 20.0])
        jumps.update(now, expected, 0.1, 0.02, [i == 300].pop)
    said = log.drain()
    assert "jumped by 0.4 m" in said[0]
    assert "stays 0.4 m" in said[1]


def test_a_step_stands_out_from_those_before_it_and_from_what_is_stated():
    def asked(steps, step, stated=1.0, passed=0.1):
        jumps = GnssJumpDetector(Events())
        for one in steps:
            jumps.update(np.array([one, 0.0, 20.0]), np.array([0.0, 0.0, 20.0]), passed)
        reported = []
        jumps.update(
            np.array([0.0, step, 99.0]),
            np.zeros(3),
            passed,
            stated,
            lambda: bool(reported.append(1)),
        )
        return bool(reported)

    steady = [0.02, -0.02] * 200
    assert asked(steady, 3.5)
    assert not asked(steady, 2.5)  # published covariances contain it
    assert asked(steady, 2.5, stated=0.5)
    assert not asked([1.0, -1.0] * 200, 3.5)  # the receiver is as noisy
    assert not asked([], 8.0)  # nothing is known of it yet
    assert not asked(steady, 3.5, passed=0.9)  # a gust
    assert not asked(steady, 15.0)  # no drone flies so far: nobody need be asked


def test_robots_distinguish_a_jump_of_some_metres_from_a_drone_that_flies(sea):
    """The receiver jumps by 6 m, or the drone is moved by as much: its robots show which."""
    robots = {"a": (2.0, 21.0), "b": (-2.0, 16.0), "c": (3.0, 14.0)}

    def flown(jump, flight):
        world = sea.World(
            robots={name: lambda _t, place=place: place for name, place in robots.items()},
            pixel_sigma=1.0,
        )
        known = {"camera.find_latency": False}  # a jump is no evidence against another latency
        engine = sea.estimator({"noise.gnss_offset_m": 1.0} | known)
        sea.play(engine, world, 8.0, until_flush=False)
        world.gnss_bias, world.drone = (jump, 0.0), lambda _t: (flight, 0.0, 30.0)
        results = sea.play(engine, world, 5.0, begin=8.1, until_flush=False)
        world.gnss_bias = (0.0, 0.0)
        return engine, results, sea.play(engine, world, 1.0, begin=13.2)

    engine, meanwhile, after = flown(6.0, 0.0)
    assert engine.happened["position_jumps"] >= 1
    for result in meanwhile[1:] + after:
        for one in result.estimates:
            error = one.position - min(
                robots.values(), key=lambda at, one=one: np.hypot(*(one.position - at))
            )
            assert error @ np.linalg.solve(one.covariance[:2, :2], error) < 9.0
    assert {one.robot_id for one in after[-1].estimates} == {"aqua_1", "aqua_2", "aqua_3"}
    assert max(np.trace(one.covariance[:2, :2]) for one in after[-1].estimates) < 4.0
    engine, meanwhile, _ = flown(0.0, 6.0)
    assert not engine.happened["position_jumps"]
    assert all(one.state.value == "confirmed" for one in meanwhile[-1].estimates)


@pytest.mark.parametrize("dive_s", [7.0, 8.05, 0.0])
def test_a_jump_that_no_robot_in_view_tells_of_is_in_their_covariances(sea, dive_s):
    """Robots dive, the receiver jumps by 6 m, and they surface: where, nobody can know."""
    robots = {"a": (2.0, 21.0), "b": (-2.0, 16.0), "c": (3.0, 14.0)}
    world = sea.World(
        robots={name: lambda _t, place=place: place for name, place in robots.items()},
        pixel_sigma=1.0,
        hidden=lambda _name, t: dive_s <= t < (10.0 if dive_s else 99.0),
    )
    engine = sea.estimator({"noise.gnss_offset_m": 1.0})
    before = sea.play(engine, world, 8.0, until_flush=False)
    world.gnss_bias = (6.0, 0.0)
    after = sea.play(engine, world, 6.0, begin=8.1)
    assert engine.happened["position_jumps"] == bool(dive_s)
    if not dive_s:  # no robot was ever seen that could be wrong by it
        return
    own = {
        one.robot_id: min(robots.values(), key=lambda at, one=one: np.hypot(*(one.position - at)))
        for one in before[30].estimates
    }
    assert {one.robot_id for one in after[-1].estimates} == set(own)
    assert len(own) == 3
    for result in after:
        for one in result.estimates:
            error = one.position - own[one.robot_id]
            assert error @ np.linalg.solve(one.covariance[:2, :2], error) < 9.0
    assert all(one.state.value == "confirmed" for one in after[-1].estimates)


@pytest.mark.parametrize(("east", "usable"), [(0.5, True), (40.0, False)])
def test_while_the_velocity_is_unknown_only_a_step_beyond_any_drone_is_a_jump(east, usable):
    """The step is not usual either: a jump of 0.3 m is conspicuous a moment later."""
    jumps, asked = GnssJumpDetector(Events()), []
    for _ in range(300):
        jumps.update(np.zeros(3), np.zeros(3), 0.1, 0.02)
    step = np.array([east, 0.0, 0.0])
    tell = [lambda: asked.append("moving") or True, lambda: asked.append("known") or True]
    settled, jump = jumps.update(step, np.zeros(3), 0.1, 0.02, tell[0], velocity_known=False)
    assert (settled, jump, asked) == (usable, None, [])
    if usable:
        jumps.update(step + np.array([0.3, 0.0, 0.0]), step, 0.1, 0.02, tell[1])
        assert asked == ["known"]
