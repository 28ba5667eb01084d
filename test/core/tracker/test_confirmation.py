# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is confirmed as a robot, and what is not."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.identity.return_position import VelocityLikelihood
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights


def _place(_t):
    """Return where a robot stays, m."""
    return (3.0, 22.0)


def test_a_glint_seen_now_and_then_is_no_robot(sea):
    world = sea.World(robots={"glint": _place}, hidden=lambda _n, t: round(10 * t) % 5 > 0)
    results = sea.play(sea.estimator(), world, 20.0)
    assert not any(result.estimates for result in results)


def test_a_glint_beside_a_robot_that_all_images_show_is_no_robot(sea):
    world = sea.World(robots={"a": lambda _t: (-3.0, 20.0), "glint": _place})
    world.hidden = lambda name, t: name == "glint" and round(10 * t) % 5 > 0
    results = sea.play(sea.estimator(), world, 20.0)
    assert {one.robot_id for result in results for one in result.estimates} == {"aqua_1"}


@pytest.mark.parametrize("missed", [0.5, 0.7, 0.8])
def test_robots_that_most_images_miss_are_tracked_under_one_label_each(sea, missed):
    """Nine in ten boxes measure a confirmed robot from the sixth second on."""
    world = sea.World(robots={"a": lambda _t: (-3.0, 20.0), "b": _place}, missed=missed, seed=2)
    world.pixel_sigma = 2.0
    results = sea.play(sea.estimator(), world, 30.0, images=15)
    late = results[len(results) // 5 :]
    shown = [one for result in late for one in result.estimates if one.state is State.CONFIRMED]
    assert len(shown) > 0.9 * (1.0 - missed) * 2 * len(late)
    assert {one.robot_id for one in shown} == {"aqua_1", "aqua_2"}


def test_false_boxes_are_never_confirmed(sea):
    results = sea.play(sea.estimator(), sea.World(clutter=0.5, seed=3), 60.0)
    assert [result.estimates for result in results if result.estimates] == []


def test_images_full_of_false_boxes_confirm_none_of_them(sea):
    """Six in a row; a robot seen before goes on, one that comes with them follows soon."""
    engine = sea.estimator()
    world = sea.World(robots={"a": _place, "b": lambda _t: (-3.0, 20.0)}, pixel_sigma=1.0)
    world.hidden = lambda name, t: name == "b" and t < 1.05
    sea.play(engine, world, 1.0, images=10, until_flush=False)
    world.clutter = 500.0
    results = sea.play(engine, world, 0.5, begin=1.1, images=10, until_flush=False)
    world.clutter = 0.0
    results += sea.play(engine, world, 1.0, begin=1.7, images=10)
    names = [[one.robot_id for one in result.estimates] for result in results]
    assert names[0] == ["aqua_1"]
    assert names[-6:] == [["aqua_1", "aqua_2"]] * 6
    assert {name for some in names for name in some} == {"aqua_1", "aqua_2"}


def test_confirmed_after_the_third_measurement_within_the_window(sea):
    world = sea.World(robots={"a": _place})
    results = sea.play(sea.estimator(), world, 1.0)
    assert [len(r.estimates) for r in results][:4] == [0, 0, 1, 1]
    slow = sea.play(sea.estimator({"tracks.confirm_window_s": 0.5}), world, 10.0, images=1)
    assert not any(r.estimates for r in slow)  # beyond what the window is stretched to


@pytest.mark.parametrize(
    ("hits", "resumed"), [((5.0, 6.0, 7.0), {}), ((5.1, 6.0, 7.0), {1: 0})], ids=["beside", "after"]
)
def test_what_was_seen_beside_a_robot_is_not_that_robot(sea, hits, resumed):
    """Even where one image alone showed both; what no image showed beside it may be it."""
    config = estimator_config({})
    tracker = Tracker(config, Labels(config))
    near = np.zeros((1, 1, 2)), np.eye(2)[None, None]
    tracker.table.filter.separations = lambda _old, _new: near
    tracker._confirmation._velocity_likelihood = lambda _rows: VelocityLikelihood(
        np.zeros((1, 2)), 1e4 * np.eye(2)[None]
    )
    tracker._confirmation.rule.first_ns = sea.stamp(0.0)
    seen = deque(sea.stamp(t) for t in (4.0, 5.0))
    came = deque(sea.stamp(t) for t in hits)
    tracker.table.tracks = [
        Track("aqua", sea.stamp(0.0), sea.stamp(5.0), State.COASTING, "aqua_1", seen),
        Track("aqua", came[0], came[-1], hits=came),
    ]
    came = tracker._confirmation._reidentify([1], sea.stamp(7.0), 30.0)
    assert (came.robots, came.waiting) == (resumed, set())


@pytest.mark.parametrize(
    ("east", "names", "ended"),
    [(1.0, ["aqua_1", "aqua_2", "aqua_3"], 0), (0.0, ["aqua_1", "aqua_4", "aqua_5"], 2)],
    ids=["where they were", "both midway"],
)
def test_two_that_come_back_as_likely_either_way_get_new_names(sea, east, names, ended):
    """One 2 m west of the other; they come back there, or one 2 m north of the other.

    Midway is as far from both places: each way has 0.5, whatever the law. A third stays in view.
    """
    robots = {"west": -1.0, "east": 1.0}
    world = sea.World(robots={"third": lambda _t: (8.0, 22.0)})
    for name, side in robots.items():
        world.robots[name] = lambda t, side=side: (
            (side, 22.0) if t < 10.0 or east else (0.0, 22.0 + side)
        )
    world.hidden = lambda name, t: name in robots and (t < 1.05 or 5.0 < t < 15.0)
    engine = sea.estimator()
    last = sea.play(engine, world, 20.0)[-1].estimates
    assert [one.robot_id for one in last] == names
    assert len([one for one in engine.take_events() if "its label ends" in one]) == ended
    assert max(np.trace(one.covariance[:2, :2]) for one in last) < 4.5  # no doubt of names


@pytest.mark.parametrize(
    ("age_s", "lasting", "ready"),
    [(0.5, False, True), (0.5, True, False), (1.9, True, False), (2.0, True, True)],
)
def test_a_track_has_lasted_when_it_began_a_window_ago(age_s, lasting, ready):
    config = estimator_config({})
    tracker = Tracker(config, Labels(config))
    now_ns = 10_000_000_000
    hits = deque(now_ns - round(t * 1e9) for t in (age_s, 0.2, 0.0))
    tracker.table.tracks = [Track("aqua", hits[0], now_ns, hits=hits, clutter_probability=0.0)]
    assert tracker._confirmation.ready(now_ns, lasting) == [0] * ready
