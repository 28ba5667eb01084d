# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Of the places of a receiver that jumps, the one where it was for longest is used."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.gnss_jump import TUNING, GnssJumpDetector
from aerial_gnss_ros.core.values.events import Events

pytestmark = pytest.mark.flights


def follow(easts, tells=True, stated=lambda _east: 1.0, passed=0.1, log=None):
    """Return displacement, step, and doubt for each image at which a receiver has jumped so far."""
    jumps, found = GnssJumpDetector(log or Events()), []
    for east in easts:
        told = lambda: tells  # noqa: E731
        step = jumps.update((float(east), 0.0) if east else (), passed, stated(east), told)
        moved = 0.0 if step is None else float(step[0])
        found.append((float(jumps.offset[0]), moved, jumps.doubt))
    return found


@pytest.mark.parametrize("east", [5.0, 50.0])
def test_a_short_jump_is_taken_out_and_forgotten(east):
    found = follow([0.0] * 50 + [east] * 20 + [0.0] * 5)
    assert {offset for offset, _, _ in found[50:70]} == {east}
    assert [doubt for _, _, doubt in found[50:56]] == [TUNING.least_present * east**2] * 6
    assert found[69][2] == pytest.approx(20 / 70 * east**2)  # the share of its time
    assert found[70:] == [(0.0, 0.0, 0.0)] * 5
    assert not any(moved for _, moved, _ in found)


def test_robots_follow_the_receiver_when_it_has_been_elsewhere_for_longer():
    found = follow([0.0] * 10 + [8.0] * 120)
    (row,) = (row for row, (_, moved, _) in enumerate(found) if moved)
    assert (row, found[row][1]) == (20, 8.0)
    assert {offset for offset, _, _ in found[row:]} == {0.0}
    assert found[-1][2] == pytest.approx(10 / 130 * 64.0)  # they may have been right before


def test_where_the_receiver_has_come_back_from_is_wrong():
    """It begins at a wrong place, where it returns for a while; it is twice at the right one."""
    found = follow([0.0] * 20 + [4.0] * 60 + [0.0] * 10 + [4.0] * 60)
    assert found[79][0] == 0.0
    assert {offset for offset, _, _ in found[80:90]} == {-4.0}
    assert found[89][2] > 1.0
    assert found[90] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("before_m", "after_m", "steps"), [(0.5, 0.02, 1), (0.02, 0.5, 0)])
def test_the_place_of_which_the_receiver_is_surer_is_used(before_m, after_m, steps):
    """Corrections that are regained move all by 2 m within 0.4 s, those lost move nothing."""
    found = follow([0.0] * 100 + [2.0] * 100, stated=lambda east: after_m if east else before_m)
    assert [moved for _, moved, _ in found[100:]].count(2.0) == steps
    assert [offset for offset, _, _ in found[102:106:3]] == [2.0, 0.0 if steps else 2.0]


def test_a_place_that_a_reference_shows_to_be_right_is_used_for_good():
    jumps = GnssJumpDetector(Events())
    for k in range(100):
        step = jumps.update((8.0, 0.0) if k > 10 else (), 0.1, 1.0, lambda: True)
        assert step is None
        if k == 15:
            assert jumps.doubt > 0.0
            jumps.confirm()
    assert jumps.doubt == 0.0
    assert jumps.offset[0] == 8.0
    jumps.update((3.0, 0.0), 0.1, 1.0, lambda: True)  # elsewhere, that may be right
    assert jumps.doubt == TUNING.least_present * 9.0


def test_a_step_that_robots_do_not_tell_of_was_flown():
    assert follow([0.0] * 5 + [8.0] * 5, tells=False)[5:] == [(0.0, 0.0, 0.0)] * 5
    assert follow([0.0] * 5 + [8.0] * 5, stated=lambda _: 3.0)[5:] == [(0.0, 0.0, 0.0)] * 5
    farthest = TUNING.jump_m + 0.1 * TUNING.jump_mps
    assert follow([0.0] * 5 + [farthest + 0.1], tells=False)[5][0] == farthest + 0.1
    assert not follow([0.0] * 5 + [farthest - 0.1], tells=False)[5][0]


def test_it_says_how_far_the_position_jumped_and_when_another_one_is_used():
    log = Events()
    follow([0.0] * 20 + [0.44] * 10 + [0.0] + [0.44] * 60, stated=lambda _: 0.02, log=log)
    jumped, back, again, used = log.drain()
    assert (
        jumped
        == again
        == ("The receiver's position jumped by 0.4 m: it is corrected by that while it is new.")
    )
    assert back == "The receiver's position jumped by 0.4 m and is back."
    assert "after its jump of 0.4 m has lasted longer" in used
    assert log.counts["position_jumps"] == 3


def test_the_earliest_places_are_forgotten_but_not_the_one_in_use():
    jumps = GnssJumpDetector(Events())
    for east in [0.0, 0.0, *range(20, 20 * 40, 20)]:
        jumps.update((float(east), 0.0), 0.1, 1.0)
    assert len(jumps._places) == TUNING.places
    assert jumps._used in jumps._places
    assert jumps.offset[0] == 20.0 * 39


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
