# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Levels and heights that contradict earlier ones: which are believed."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.plausibility import Plausibility
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.core.values.samples import Fix, Scalar


def _judged(*levels):
    """Return which of some levels (time in s, m) are believed."""
    door = Plausibility(estimator_config({}))
    return [door.level(Scalar(round(t * 1e9), value)) == "" for t, value in levels]


def test_one_level_that_cannot_be_is_refused_and_later_ones_are_not():
    assert _judged((0, 0.0), (1, -180.0), (2, 0.1), (3, 4.9), (4, 9.8)) == [
        True, False, True, True, True,
    ]  # fmt: skip
    assert _judged((0, 0.0), (1, 5.1), (1000, 5.1)) == [True, False, False]


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e5])
def test_what_is_no_level_is_refused(value):
    assert _judged((0, 0.0), (1, value), (2, 0.0)) == [True, False, True]


def test_another_level_counts_when_it_lasts():
    long = [(t, 0.0) for t in range(60)]
    corrected = [(60 + t, -12.0) for t in range(15)]
    believed = _judged(*long, *corrected)
    assert all(believed[:60])
    assert believed[60:] == [False] * 10 + [True] * 5


def test_a_wrong_level_in_flight_moves_no_robot(sea):
    """It made the height above the water ten times as large until the next one came."""
    robots = {"a": lambda _t: (3.0, 22.0), "b": lambda _t: (-12.0, 25.0)}
    world, engine = sea.World(robots=robots, pixel_sigma=1.0), sea.estimator()
    engine.add_water_level(Scalar(sea.stamp(0.0), 0.0))
    results = sea.play(engine, world, 6.0, until_flush=False)
    engine.add_water_level(Scalar(sea.stamp(6.05), -180.0))
    results += sea.play(engine, world, 2.0, begin=6.1)
    assert "water does not move that fast" in " ".join(engine.events)
    for result in results[-20:]:
        assert [one.robot_id for one in result.estimates] == ["aqua_1", "aqua_2"]
        for one in result.estimates:
            assert min(math.dist(one.position, place(0.0)) for place in robots.values()) < 5.0


def test_a_level_that_lasts_begins_the_tracks_anew(sea):
    engine = sea.estimator()
    world = sea.World(robots={"a": lambda _t: (3.0, 22.0)}, pixel_sigma=1.0)
    results = sea.play(engine, world, 6.0, until_flush=False)
    assert results[-1].estimates
    for i in range(70):
        engine.add_water_level(Scalar(sea.stamp(6.0 + 0.1 * i), 0.0 if i < 20 else -12.0))
    assert engine.happened["began_elsewhere"] == 1
    assert engine.robots == ()


def _flown(door, judge, metres, begin_s):
    """Return how many of 20 s of heights, at 10 Hz and with noise, are believed."""
    heights = [
        Scalar(round((begin_s + 0.1 * i) * 1e9), metres + 0.01 * (i % 3)) for i in range(200)
    ]
    return sum(judge(door, one) for one in heights)


@pytest.mark.parametrize("level_m", [0.0, -60.0])
def test_a_height_from_which_no_robot_is_seen_replaces_none(level_m):
    """A height of -30 m, after one of 30 m, may be right only where the water is 60 m lower."""
    door = Plausibility(estimator_config({}))
    door.level(Scalar(1, level_m))
    believed = lambda door, one: door.height(one)[0] == ""  # noqa: E731
    assert _flown(door, believed, 30.0, 1.0) == 200
    refused = 200 - _flown(door, believed, -30.0, 21.0)
    assert refused == (200 if level_m == 0.0 else pytest.approx(100, abs=1))  # 10 s
    moved = door.pop_relocation()
    assert moved == (
        "" if level_m == 0.0 else "The height is -30.0 m, 60 m from what it was before"
    )


def test_an_altitude_below_the_water_replaces_none():
    above = {"height.source": "none", "surface.altitude": -40.0, "fix.altitude_datum": "ellipsoid"}
    door = Plausibility(estimator_config(above))
    believed = lambda door, one: door.fix(Fix(one.stamp_ns, 0.2, -1.0, one.value))[0] == ""  # noqa: E731
    assert _flown(door, believed, -10.0, 1.0) == 200
    assert _flown(door, believed, -70.0, 21.0) == 0
    assert _flown(door, believed, 50.0, 41.0) > 90


def test_robots_coast_while_the_sign_of_the_height_is_wrong(sea):
    world = sea.World(robots={"a": lambda _t: (3.0, 22.0)}, pixel_sigma=1.0)
    engine = sea.estimator()
    sea.play(engine, world, 6.0, until_flush=False)
    right, world.height = world.height, lambda t: Scalar(sea.stamp(t), -right(t).value)
    wrong = sea.play(engine, world, 15.0, begin=6.05, until_flush=False)
    assert {one.reason for each in wrong[5:] for one in each.rejections} == {Reason.BAD_HEIGHT}
    world.height = right
    again = sea.play(engine, world, 3.0, begin=21.1)
    assert engine.happened["began_elsewhere"] == 0
    assert [one.robot_id for one in again[-1].estimates] == ["aqua_1"]
    assert again[-1].estimates[0].state is State.CONFIRMED
