# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots move as their class may: in the filter, at the gate of speeds, and out of sight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.models.motion_model import MotionModel, MotionOf
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Reason

SWIMS = {
    "slow": lambda t: (-6.0 + 0.3 * t, 17.0),
    "fast": lambda t: (-20.0 + 3.0 * t, 24.0 - 0.05 * t),
}


def classed(sea, **more):
    """Return a world whose robots are of two classes: boats swim in its upper half."""

    class Mixed(sea.World):
        def frame(self, t, class_id="aqua"):
            found = super().frame(t, class_id)
            names = tuple("boat" if v < 300.0 else class_id for v in found.centers[:, 1])
            return replace(found, class_ids=names)

    return Mixed(robots=SWIMS, **more)


def names_of(results, class_id):
    """Return the names of confirmed robots of a class."""
    return {
        one.robot_id
        for result in results
        for one in result.estimates
        if one.class_id == class_id and one.state is State.CONFIRMED
    }


def test_a_boat_may_be_faster_than_other_robots(sea):
    own = {"classes.boat.max_speed": 5.0}
    for values, boats, refused in ((own, {"boat_1"}, 0), ({}, set(), 10)):
        engine = sea.estimator(values)
        results = sea.play(engine, classed(sea), 8.0)
        assert names_of(results, "aqua") == {"aqua_1"}
        if boats:
            assert names_of(results, "boat") == boats
        assert engine.counts[Reason.TOO_FAST] >= refused
        assert (engine.counts[Reason.TOO_FAST] == 0) is (not refused)


def test_a_class_may_be_slower_than_other_robots(sea):
    engine = sea.estimator({"tracks.max_speed": 5.0, "classes.boat.max_speed": 1.0})
    sea.play(engine, classed(sea), 8.0, images=10)
    assert engine.counts[Reason.TOO_FAST] > 10


def test_a_class_that_hardly_turns_is_known_better(sea):
    still = classed(sea, pixel_sigma=2.0)
    still.robots = {"aqua": lambda _t: (-6.0, 17.0), "boat": lambda _t: (0.0, 24.0)}
    results = sea.play(sea.estimator({"classes.boat.acceleration": 0.0}), still, 10.0)
    sigma = {one.class_id: one.covariance[2, 2] for one in results[-1].estimates}
    assert sigma["boat"] < 0.5 * sigma["aqua"]


def test_robots_are_lost_when_they_have_been_down_longer_than_their_class_dives(sea):
    world = classed(sea, hidden=lambda _name, t: t > 5.0)
    world.robots = {"aqua": lambda _t: (-6.0, 17.0), "boat": lambda _t: (0.0, 24.0)}
    results = sea.play(sea.estimator({"classes.boat.coast_s": 4.0}), world, 12.0)
    seen = {(one.class_id, (r.stamp_ns - sea.stamp(0.0)) // 10**9)
            for r in results for one in r.estimates}  # fmt: skip
    assert {t for name, t in seen if name == "aqua"} >= set(range(1, 12))
    assert max(t for name, t in seen if name == "boat") == 9


def test_equal_classes_move_as_robots_without_any(sea):
    """The largest of the differences is that of the last bit."""
    stated = {"tracks.max_speed": 0.8, "noise.robot_acceleration": 0.1, "tracks.coast_s": 30.0}
    own = {
        f"classes.{name}.{key}": value
        for name in ("aqua", "boat")
        for key, value in (("max_speed", 0.8), ("acceleration", 0.1), ("coast_s", 30.0))
    }
    hidden = {"hidden": lambda name, t: name == "slow" and 6.0 < t < 9.0}
    plain, classes = (
        sea.play(sea.estimator(values), classed(sea, pixel_sigma=2.0, **hidden), 12.0)
        for values in (stated, own)
    )
    for one, other in zip(plain, classes, strict=True):
        assert [a.robot_id for a in one.estimates] == [b.robot_id for b in other.estimates]
        for a, b in zip(one.estimates, other.estimates, strict=True):
            assert a.covariance == pytest.approx(b.covariance, rel=1e-6, abs=1e-9)
            assert a.position == pytest.approx(b.position, abs=1e-6)


def test_each_robots_step_is_that_of_its_own_motion():
    unseen, strength = np.array([0.0, 0.0, 5.0]), np.array([1.0, 4.0, 1.0])
    both = MotionOf(np.array([0.05, 0.2, 0.05]), np.array([0.75, 0.1, 0.4]))
    for away in (np.zeros(3), unseen):
        _, _, noise = both.step(0.1, away, strength)
        for i in range(3):
            alone = MotionModel(float(both.acceleration[i]), float(both.speed_sigma[i]))
            _, _, own = alone.step(0.1, away[i : i + 1], strength[i : i + 1])
            assert noise[i] == pytest.approx(own[0], rel=1e-12)


def out_of_view(seconds):
    """Return reach and variance of a place whose robot was known to 5 cm and 5 cm/s at first."""
    motion, unseen = MotionModel(0.05, 0.75), np.zeros(1)
    P, F = 0.05**2 * np.eye(2), np.eye(2)
    for _ in range(round(seconds / 0.2)):
        reach, kept, ((pp, pv, vv),) = motion.step(0.2, unseen)
        step = np.array([[1.0, reach[0]], [0.0, 1.0 if kept is None else kept[0]]])
        P, F = step @ P @ step.T + np.array([[pp, pv], [pv, vv]]), step @ F
        unseen = unseen + 0.2
    return F[0, 1], P[0, 0]


@pytest.mark.parametrize("seconds", [2.0, 3.0, 5.0, 8.0, 15.0, 30.0])
def test_out_of_view_the_covariance_contains_a_robot_that_turns_back(seconds):
    """At 0.9 m/s, by 180 deg within 2 s: which a single time constant of 4 s or more does not."""
    reach, variance = out_of_view(seconds)
    turning = min(seconds, 2.0)
    ahead = 0.9 * np.sin(np.pi * turning / 2.0) / (np.pi / 2.0) - 0.9 * (seconds - turning)
    aside = 0.9 * (1.0 - np.cos(np.pi * turning / 2.0)) / (np.pi / 2.0)
    assert ((ahead - 0.9 * reach) ** 2 + aside**2) / variance < 13.8


@pytest.mark.parametrize("seconds", [2.0, 5.0, 15.0, 30.0, 60.0])
def test_out_of_view_the_covariance_contains_a_robot_that_goes_straight_on(seconds):
    """At 1.4 m/s: which a single time constant of 6 s or less does not."""
    reach, variance = out_of_view(seconds)
    assert (1.4 * (seconds - reach)) ** 2 / variance < 13.8
