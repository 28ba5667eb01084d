# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots keep their names: crossings, dives, misses, false boxes, a platform that is wrong."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

MEETING_S = 17.0
"""A time at which two of them are close, s."""
CROSSING = {
    "a": lambda t: (0.3 * t - 5.0, 17.0),
    "b": lambda t: (5.0 - 0.3 * t, 18.0),
    "c": lambda _t: (3.0, 22.0),
}
BIAS = {"gnss_bias": (1.5, -1.0), "rpy_bias_deg": (0.3, -0.4, 1.5)}


def _orbit(radius=28.0, height=30.0, rate=0.1):
    """Fly round the robots, the camera always on them."""
    return {
        "drone": lambda t: (
            radius * math.cos(rate * t),
            20.0 + radius * math.sin(rate * t),
            height,
        ),
        "rpy_deg": lambda t: (0.0, 47.0, math.degrees(rate * t) + 180.0),
    }


def _apparent(sea, world, result):
    """Return where each robot in view seems to be through the wrong telemetry, by its name."""
    t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
    places = np.array([place(t) for place in world.robots.values()])
    pixels, inside = sea.project_to_image(world.pose(t), sea.camera, *world.local.places(places))
    points = locate(result.pose, sea.camera, pixels, Noise())
    seen = world.local.positions(points.latitude, points.longitude)
    return {name: seen[i] for i, name in enumerate(world.robots) if inside[i]}


def _owners(sea, world, results):
    """Return which robots each name was nearest to (within 1 m) while confirmed."""
    owners = {}
    for result in results:
        apparent = _apparent(sea, world, result)
        for estimate in result.estimates:
            if estimate.state is State.CONFIRMED:
                near = {k: np.hypot(*(estimate.position - at)) for k, at in apparent.items()}
                robot = min(near, key=near.get)
                owner = robot if near[robot] < 1.0 else "nobody"
                owners.setdefault(estimate.robot_id, set()).add(owner)
    return owners


def test_robots_with_other_labels_are_the_same_robots(sea):
    """Also while two of them are close, and which is which is open."""
    other = {"aqua_1": "aqua_3", "aqua_2": "aqua_1", "aqua_3": "aqua_2"}
    flown = []
    for names in ({}, other):
        engine, world = sea.estimator(), sea.World(robots=CROSSING, pixel_sigma=2.0, seed=4)
        sea.play(engine, world, MEETING_S, until_flush=False)
        assert engine._tracks.pipeline.tracking._encounters.ambiguous
        engine._tracks.pipeline.tracking.rename(names)
        results = sea.play(engine, world, 5.0, begin=MEETING_S + 0.1)
        flown.append([(result.stamp_ns, one.robot_id, *one.covariance.ravel())
                      for result in results for one in result.estimates])  # fmt: skip
    assert sorted((at, other[name], *rest) for at, name, *rest in flown[0]) == sorted(flown[1])


@pytest.mark.parametrize("flight", [{}, _orbit()], ids=["hover", "orbit"])
def test_three_crossing_robots_keep_their_names(sea, flight):
    world = sea.World(
        robots=CROSSING, pixel_sigma=2.0, missed=0.2, clutter=0.15, seed=4, **BIAS, **flight
    )
    results = sea.play(sea.estimator(), world, 35.0)
    owners = _owners(sea, world, results)
    assert sorted(owners) == ["aqua_1", "aqua_2", "aqua_3"]
    assert sorted(sorted(robots) for robots in owners.values()) == [["a"], ["b"], ["c"]]


def test_a_robot_that_turns_hard_keeps_its_one_track(sea):
    """A circle of 0.8 m at 0.7 m/s: 0.6 m/s², ten times what the model expects in a second."""

    def place(t):
        return (0.8 * math.cos(0.875 * t), 18.0 + 0.8 * math.sin(0.875 * t))

    world = sea.World(robots={"a": place, "b": CROSSING["c"]}, pixel_sigma=2.0, missed=0.1, **BIAS)
    results = sea.play(sea.estimator(), world, 25.0)
    assert {e.robot_id for r in results for e in r.estimates} == {"aqua_1", "aqua_2"}
    assert all(len(owner) == 1 for owner in _owners(sea, world, results).values())


@pytest.mark.parametrize("dive_s", [1.0, 30.0])
def test_a_dive_ends_under_the_same_name(sea, dive_s):
    world = sea.World(
        robots=CROSSING,
        pixel_sigma=2.0,
        hidden=lambda name, t: name == "a" and 8.0 <= t < 8.0 + dive_s,
        **BIAS,
    )
    results = sea.play(sea.estimator(), world, 12.0 + dive_s, images=5)
    assert all(len(owner) == 1 for owner in _owners(sea, world, results).values())
    name = next(k for k, v in _owners(sea, world, results).items() if v == {"a"})
    mine = [e for r in results for e in r.estimates if e.robot_id == name]
    assert len({e.robot_id for r in results for e in r.estimates}) == 3
    dived = [e for e in mine if e.state is State.COASTING]
    assert len(dived) == pytest.approx(dive_s * 5.0, abs=3)
    sigmas = [math.sqrt(np.linalg.det(e.covariance[:2, :2])) for e in dived]
    assert all(np.diff(sigmas) > 0.0)
    assert mine[-1].state is State.CONFIRMED


def test_a_robot_that_turns_back_unseen_keeps_its_name(sea):
    """It swims at 0.5 m/s, is hidden for 3 s, and comes back where it came from."""

    def place(t):
        return (0.5 * (t if t < 9.5 else 19.0 - t), 18.0)

    world = sea.World(
        robots={"a": place}, pixel_sigma=2.0, hidden=lambda _name, t: 8.0 <= t < 11.0, **BIAS
    )
    results = sea.play(sea.estimator(), world, 18.0)
    assert {e.robot_id for result in results for e in result.estimates} == {"aqua_1"}
    assert results[-1].estimates[0].state is State.CONFIRMED


@pytest.mark.parametrize(("unseen_s", "size"), [(1.5, 0.4), (6.0, 1.0)])
def test_seen_again_from_the_other_side_with_a_wrong_compass(sea, unseen_s, size):
    """4 deg of heading at 25 m: the robot seems 1.7 m to one side, then 1.7 m to the other.

    From lower in a shorter time: a drone that flies 50 m at once is a receiver that jumps.
    """
    begin, end = 4.0, 4.0 + unseen_s
    far = lambda t: t > 0.5 * (begin + end)  # noqa: E731
    world = sea.World(
        drone=lambda t: (
            0.0,
            size * 50.0 * float(np.clip((t - begin) / unseen_s, 0.0, 1.0)),
            size * 30.0,
        ),
        rpy_deg=lambda t: (0.0, 50.0, -90.0 if far(t) else 90.0),
        rpy_bias_deg=(0.0, 0.0, 4.0),
        robots={"a": lambda _t: (0.0, size * 25.0)},
        hidden=lambda _name, t: begin < t < end,
        pixel_sigma=1.0,
    )
    results = sea.play(sea.estimator(), world, end + 3.0, images=5)
    first, last = results[15].estimates[0], results[-1].estimates[0]
    assert {e.robot_id for r in results for e in r.estimates} == {"aqua_1"}
    assert last.state is State.CONFIRMED
    if unseen_s < 2.0:  # within confirm_window_s the gate itself lets it in, at once
        again = next(r for r in results if r.stamp_ns >= sea.stamp(end))
        assert again.estimates[0].state is State.CONFIRMED
    assert first.position[0] == pytest.approx(-1.75 * size, abs=0.2 * size)
    # the two sides show the compass's error; a robot that could have moved meanwhile shows less
    assert abs(last.position[0]) < size * (0.6 if unseen_s < 2.0 else 1.7)


@pytest.mark.parametrize("stays_s", [0.05, 10.0], ids=["one stray box", "a jump"])
def test_a_name_does_not_alternate_while_two_divers_are_distinguished(sea, stays_s):
    """One of two divers comes up between both, and while it waits for its name a box is 0.6 m off.

    A second track begins there; that makes it neither two robots nor two names.
    """

    def place(t):
        return (-2.0 if t < 5.0 else 0.6 * (13.0 <= t < 13.0 + stays_s), 18.0)

    world = sea.World(
        robots={"a": place, "b": lambda _t: (2.0, 18.0)},
        hidden=lambda name, t: 4.0 < t < 12.0 or (name == "b" and t >= 12.0),
        pixel_sigma=2.0,
        **BIAS,
    )
    results = sea.play(sea.estimator(), world, 18.0)
    worn = [
        [e.robot_id for e in result.estimates if e.state is State.CONFIRMED]
        for result in results
        if result.stamp_ns >= sea.stamp(12.0)
    ]
    changes = [new for old, new in itertools.pairwise(worn) if new != old]
    assert [len(names) for names in changes] == [1]


def test_a_robot_unseen_for_too_long_is_lost_and_its_name_used_up(sea):
    world = sea.World(robots={"a": CROSSING["c"]}, hidden=lambda _n, t: 3.0 < t < 15.0)
    results = sea.play(sea.estimator({"tracks.coast_s": 5.0}), world, 18.0, images=10)
    at = {round((r.stamp_ns - sea.stamp(0)) * 1e-9, 1): r.estimates for r in results}
    assert [e.robot_id for e in at[7.9]] == ["aqua_1"]
    assert at[8.2] == ()
    assert [e.robot_id for e in at[18.0]] == ["aqua_2"]


def test_a_box_of_another_class_updates_no_robot_and_makes_no_second_one(sea):
    """Every other image calls it a buoy."""
    engine = sea.estimator()
    world = sea.World(robots={"a": CROSSING["c"]})
    engine.add_camera(sea.stamp(0.0), sea.camera)
    results = []
    for i in range(20):
        t = 0.1 * i
        engine.add_fix(world.fix(t))
        engine.add_gimbal(world.gimbal(t))
        engine.add_height(world.height(t))
        engine.add_detections(world.frame(t, "buoy" if i % 2 else "aqua"))
        results += engine.advance(sea.stamp(t))
    assert {e.robot_id for r in results for e in r.estimates} == {"aqua_1"}
    states = [r.estimates[0].state for r in results[-6:]]
    assert states == [State.CONFIRMED, State.COASTING] * 3


def test_a_second_box_on_a_robot_is_gated(sea):
    engine, world = sea.estimator(), sea.World(robots={"a": CROSSING["c"]})
    plain = world.frame
    world.frame = lambda t: sea.boxes(t, np.vstack([plain(t).centers, plain(t).centers + 3.0]))
    results = sea.play(engine, world, 2.0)
    assert [e.robot_id for e in results[-1].estimates] == ["aqua_1"]
    assert {str(reason): n for reason, n in engine.counts.items()} == {"gated": len(results)}


def test_a_frame_full_of_false_boxes_is_survived(sea):
    engine = sea.estimator()
    world = sea.World(robots=CROSSING, pixel_sigma=1.0, seed=9)
    sea.play(engine, world, 3.0, until_flush=False)
    world.clutter = 500.0
    results = sea.play(engine, world, 0.1, begin=3.1, until_flush=False)
    world.clutter = 0.0
    results += sea.play(engine, world, 3.0, begin=3.3)
    assert {e.robot_id for e in results[-1].estimates} == {"aqua_1", "aqua_2", "aqua_3"}
    assert {e.state for e in results[-1].estimates} == {State.CONFIRMED}


def test_errors_fit_the_published_covariance(sea):
    """Platform errors drawn anew for each flight; the state's error must fit its covariance."""
    rng = np.random.default_rng(11)
    distances = []
    for seed in range(12):
        drawn = rng.standard_normal(5) * (1.2, 1.2, 0.4, 0.4, 1.5)
        world = sea.World(
            robots={"a": CROSSING["c"]},
            gnss_bias=tuple(drawn[:2]),
            rpy_bias_deg=tuple(drawn[2:]),
            pixel_sigma=2.0,
            seed=seed,
            **_orbit(),
        )
        last = sea.play(sea.estimator(), world, 12.0, images=5)[-1].estimates[0]
        error = np.concatenate([last.position - (3.0, 22.0), last.velocity])
        distances.append(error @ np.linalg.solve(last.covariance, error))
    # 48 degrees of freedom; 99.9 % of such sums lie below 84, and the height is exact here
    assert 8.0 < sum(distances) < 84.0


def test_in_the_end_only_boxes_of_tracks_older_than_the_window_are_given_up():
    config = estimator_config({})
    tracker, ended = Tracker(config, Labels(config)), []
    window_ns = tracker._confirmation.rule.window_ns
    tracker._stamp_ns, tracker._end = 10 * window_ns, ended.extend
    tracker.table.tracks = [Track("aqua", 9 * window_ns - late, 10 * window_ns) for late in (0, 1)]
    tracker.end()
    assert ended == tracker.table.tracks[1:]
