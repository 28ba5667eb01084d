# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights whose telemetry is wrong for a moment: robots keep names and sigmas, or say so."""

from __future__ import annotations

import copy
import itertools
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from aerial_gnss_ros.core.filter import blocks
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

ROBOTS = {
    "a": lambda _t: (2.0, 21.0),
    "b": lambda _t: (-4.0, 12.0),
    "c": lambda _t: (5.0, 14.0),
    "d": lambda _t: (-1.0, 28.0),
}


class Flights:
    """Flights in which telemetry turns and turns back; all begin alike, so that is flown once."""

    def __init__(self, sea, images=5):
        self.sea, self._begun, self._right = sea, {}, {}
        self._play = partial(sea.play, images=images)

    def _beginning(self, before, robots):
        """Return results, engine and world of 6 s with so many of the robots in view."""
        key = before, robots
        if key not in self._begun:
            names = itertools.islice(ROBOTS, robots)
            world = self.sea.World(robots={name: ROBOTS[name] for name in names}, pixel_sigma=1.0)
            world.hidden = lambda name, _t: list(ROBOTS).index(name) >= before
            engine = self.sea.estimator({"noise.gnss_offset_m": 0.02})
            results = self._play(engine, world, 6.0, until_flush=False)
            self._begun[key] = results, engine, world
        return copy.deepcopy(self._begun[key], {id(self.sea.camera): self.sea.camera})

    def flown(self, turn_deg, wrong_s, before=4, after=4):
        """Return the results, and the engine, of a flight.

        Args:
            turn_deg: (3,) roll, pitch, yaw.
            wrong_s: for how long, from 6 s on.
            before: robots in view until telemetry is right again.
            after: and from then on.
        """
        results, engine, world = self._beginning(before, max(before, after))
        end = 6.05 + wrong_s
        world.hidden = lambda name, t: list(ROBOTS).index(name) >= (before if t < end else after)
        if wrong_s:
            world.rpy_bias_deg = turn_deg
            results += self._play(engine, world, wrong_s - 0.1, begin=6.1, until_flush=False)
            world.rpy_bias_deg = (0.0, 0.0, 0.0)
        return results + self._play(engine, world, 4.0, begin=6.1 + wrong_s), engine

    def right(self, before=4, after=4):
        """Return the sigmas at the end of a flight whose telemetry is right."""
        key = before, after
        if key not in self._right:
            self._right[key] = _sigmas(self.flown((0.0, 0.0, 0.0), 0.0, before, after)[0][-1])
        return self._right[key]


@pytest.fixture(scope="module")
def flights(sea):
    """Return the flights of this module."""
    return Flights(sea)


@pytest.fixture(scope="module")
def at_ten(sea):
    """Return such flights with ten images a second."""
    return Flights(sea, 10)


def _sigmas(result):
    seen = [one for one in result.estimates if one.state is State.CONFIRMED]
    return {one.robot_id: np.sqrt(np.trace(one.covariance[:2, :2])) for one in seen}


@pytest.mark.parametrize("turn_deg", [(0.0, 0.0, 30.0), (0.0, -8.0, 0.0)], ids=["yaw", "pitch"])
@pytest.mark.parametrize("wrong_s", [0.1, 0.5, 3.0])
@pytest.mark.parametrize(("before", "after"), [(4, 4), (4, 2), (4, 1), (2, 2)])
def test_robots_are_known_as_well_as_before(flights, turn_deg, wrong_s, before, after):
    results, _ = flights.flown(turn_deg, wrong_s, before, after)
    known, found = flights.right(before, after), _sigmas(results[-1])
    assert found.keys() == known.keys()
    for name, sigma in found.items():
        assert sigma < 1.3 * known[name], name


@pytest.mark.parametrize("turn_deg", [(0.0, 0.0, 30.0), (0.0, -20.0, 0.0)], ids=["yaw", "pitch"])
@pytest.mark.parametrize("wrong_s", [0.5, 3.0, 10.0])
def test_a_lone_robot_is_not_somewhere_else_for_sure(at_ten, turn_deg, wrong_s):
    """No other robot outvotes a telemetry that jumps; but cameras do not turn so fast."""
    results, engine = at_ten.flown(turn_deg, wrong_s, 1, 1)
    for result in results:
        for one in result.estimates:
            off = one.position - np.array(ROBOTS["a"](0.0))
            assert off @ np.linalg.solve(one.covariance[:2, :2], off) < 13.8, one.robot_id
    assert results[-1].estimates[0].robot_id == "aqua_1"
    assert results[-1].estimates[0].state is State.CONFIRMED
    # what is new must last 2 s, so that a shorter moment leaves no names behind
    assert len(results[-1].estimates) == (1 if wrong_s < 2.0 else 2)
    events = " ".join(engine.events)
    assert "orientation jumped by" in events
    assert "orientation is back where it was" in events


def test_a_camera_that_turns_fast_has_not_jumped(sea):
    """At 100 deg/s to robots elsewhere, which are named as fast as any."""
    robots = {"a": lambda _t: (2.0, 21.0), "b": lambda _t: (21.0, -3.0)}
    world = sea.World(robots=robots, rpy_deg=lambda t: (0.0, 60.0, 90.0 - 100.0 * _ramp(t)))
    engine = sea.estimator()
    results = sea.play(engine, world, 6.0)
    assert not any("jumped" in event for event in engine.events)
    assert {one.robot_id for one in results[-1].estimates} == {"aqua_1", "aqua_2"}
    assert min(r.stamp_ns for r in results if len(r.estimates) == 2) <= sea.stamp(4.3)


def _ramp(t):
    """Return how far it has turned, s, from 3 s on for 0.9 s."""
    return min(max(t - 3.0, 0.0), 0.9)


def test_what_robots_tell_counts_for_those_of_other_groups(sea, monkeypatch):
    """One camera: the robots of all groups end the doubt about it."""
    monkeypatch.setattr(blocks, "TUNING", replace(blocks.TUNING, block_robots=1))
    flights = Flights(sea)
    results, _ = flights.flown((0.0, 0.0, 30.0), 1.0)
    known, found = flights.right(), _sigmas(results[-1])
    assert found.keys() == known.keys()
    assert all(sigma < 1.3 * known[name] for name, sigma in found.items())
