# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A water level holds until it is replaced, so a single wrong one must not count."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.plausibility import Plausibility
from aerial_gnss_ros.core.values.samples import Scalar


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
