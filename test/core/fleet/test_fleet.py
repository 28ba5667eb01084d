# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several drones together: as one alone, better than alone, apart where they share nothing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.fleet.fleet import Fleet, refuse_unable
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import MapDatum, State

pytestmark = pytest.mark.flights


@pytest.mark.parametrize(
    ("kind", "speed", "missed"), [("hover", 0.0, 0.0), ("orbit", 0.3, 0.0), ("hover", 0.4, 0.3)]
)
def test_one_drone_together_is_one_drone_alone(fleet_of, kind, speed, missed):
    """To a millimetre, also where robots leave the view, return or turn."""
    flown = fleet_of(
        kind=kind, count=1, speed=speed, missed=missed, seed=7, duration=20.0, images=10.0
    )
    single = {result.stamp_ns: result.estimates for result in flown.alone["a"]}
    _, updates = flown.together()
    apart = []
    for _, seen, update in updates:
        of = {one.robot_id: one for one in single[seen.stamp_ns]}
        assert [one.robot_id for one in update.estimates] == sorted(of)
        for one in update.estimates:
            other = of[one.robot_id]
            assert one.state == other.state
            places = [flown.local.positions([e.latitude], [e.longitude])[0] for e in (one, other)]
            apart.append(math.dist(*places))
            assert one.sigma == pytest.approx(other.sigma, rel=0.005)
    assert len(apart) > 500
    assert max(apart) < 0.001


def test_two_drones_on_opposite_sides_are_far_better_than_one(two_rtk):
    _, updates = two_rtk.together()
    both = two_rtk.rms([update.estimates for _, _, update in updates], 8.0)
    alone = [
        two_rtk.rms([result.estimates for result in results], 8.0)
        for results in two_rtk.alone.values()
    ]
    sigma = np.mean([one.sigma for one in updates[-1][2].estimates])
    alone_sigma = np.mean([one.sigma for one in two_rtk.alone["a"][-1].estimates])
    assert both < min(alone) or both < 0.06
    assert math.sqrt(np.mean(np.square(alone))) / both > 1.5
    assert alone_sigma / sigma > 1.7


def test_robots_of_both_drones_get_one_name_and_keep_it(two_rtk):
    _, updates = two_rtk.together()
    true = {}
    for _, _, update in updates:
        for name, (_, robot) in two_rtk.errors(update.estimates).items():
            true.setdefault(name, robot)
            assert true[name] == robot
    assert sorted(true.values()) == [0, 1, 2]
    late = [(name, update.names) for name, seen, update in updates[len(updates) // 2 :]]
    for drone in ("a", "b"):
        known = {tuple(sorted(names.items())) for name, names in late if name == drone}
        assert len(known) == 1
        assert {fleet for _, fleet in known.pop()} == set(true)
    assert not any(update.report.disagrees for _, _, update in updates)
    assert updates[-1][2].report.shared == 3
    assert updates[-1][2].report.agreement == pytest.approx(1.0, abs=0.3)
    assert not updates[-1][2].report.disagrees


def test_the_order_of_simultaneous_images_hardly_matters(two_rtk):
    last = []
    for order in ("ab", "ba"):
        estimates = two_rtk.together(order=order)[1][-1][2].estimates
        of = two_rtk.errors(estimates)  # the first drone's names are the fleet's
        last.append({of[one.robot_id][1]: one for one in estimates})
    for robot, one in last[0].items():
        both = (one, last[1][robot])
        places = [two_rtk.local.positions([e.latitude], [e.longitude])[0] for e in both]
        assert math.dist(*places) < 0.25 * one.sigma


def test_drones_that_share_no_robot_stay_apart_without_harm(fleet_of):
    flown = fleet_of(noises=("rtk", "rtk"), seed=5, duration=8.0)
    for name, robots in (("a", {0}), ("b", {1, 2})):
        for k, seen in enumerate(flown.sightings[name]):
            keep = [
                i for i, label in enumerate(seen.labels)
                if label and nearest(flown, name, seen, label) in robots
            ]  # fmt: skip
            flown.sightings[name][k] = only(seen, keep)
    _, updates = flown.together()
    last = updates[-1][2].estimates
    found = flown.errors(last)
    assert sorted(robot for _, robot in found.values()) == [0, 1, 2]
    assert all(len(robot.labels) == 1 for robot in _fleet_robots(flown))
    for one in last:
        assert found[one.robot_id][0] < 4.0 * one.sigma


def nearest(flown, drone, seen, label):
    """Return the true robot that a drone's label stands for."""
    result = next(r for r in flown.alone[drone] if r.stamp_ns == seen.stamp_ns)
    (one,) = (e for e in result.estimates if e.robot_id == label)
    return flown.errors([one])[label][1]


def only(seen, keep):
    """Return a sighting with some of its boxes."""
    return replace(
        seen,
        labels=tuple(seen.labels[i] for i in keep),
        tracks=tuple(seen.tracks[i] for i in keep),
        class_ids=tuple(seen.class_ids[i] for i in keep),
        pixels=seen.pixels[keep].reshape(-1, 2),
        doubt=seen.doubt[keep].reshape(-1, 2, 2),
    )


def _fleet_robots(flown):
    return flown.together()[0].table.robots


def test_a_robot_that_no_drone_sees_coasts_and_ends(two_rtk):
    fleet, updates = two_rtk.together()
    _, seen, _ = updates[-1]
    coast_s = two_rtk.configs["a"].tracks.coast_s
    states = []
    for seconds in (0.5, coast_s - 1.0, coast_s + 1.0):
        later = moved(only(seen, []), seconds)
        states.append({one.state for one in fleet.update("b", later).estimates})
    # Half a second later the other drone's last image still showed them.
    assert states == [{State.CONFIRMED}, {State.COASTING}, set()]


def test_while_all_drones_are_silent_robots_are_predicted_and_end(two_rtk):
    fleet, updates = two_rtk.together()
    last = updates[-1][2].estimates
    stamp_ns, coast_s = last[0].stamp_ns, two_rtk.configs["a"].tracks.coast_s
    for seconds in (3.0, 8.0):
        later = fleet.predicted(stamp_ns + round(seconds * 1e9))
        assert [one.robot_id for one in later] == [one.robot_id for one in last]
        assert {one.state for one in later} == {State.COASTING}
        for one, before in zip(later, last, strict=True):
            expected = before.position + seconds * before.velocity
            assert np.linalg.norm(one.position - expected) < 0.2 * seconds
            assert one.sigma > before.sigma + 0.01 * seconds
            assert one.stamp_ns == stamp_ns + round(seconds * 1e9)
    assert fleet.predicted(stamp_ns + round((coast_s + 1.0) * 1e9)) == ()
    again = fleet.predicted(stamp_ns)
    for one, before in zip(again, last, strict=True):  # the state has not changed
        np.testing.assert_array_equal(one.position, before.position)
    assert Fleet(two_rtk.configs, two_rtk.local).predicted(stamp_ns) == ()


def test_a_fleet_that_is_made_again_keeps_its_names(two_rtk):
    fleet, _ = two_rtk.together()
    for robot, name in zip(fleet.table.robots, ("x", "y", "z"), strict=True):
        robot.name = name
    names = {label: robot.name for robot in fleet.table.robots for label in [robot.labels[1]]}
    anew = Fleet({name: two_rtk.configs[name] for name in "ba"}, two_rtk.local)
    anew.follow(fleet)
    for seen in two_rtk.sightings["b"]:
        update = anew.update("b", seen)
    assert update.names == names


def moved(seen, seconds):
    """Return a sighting some time later."""
    step = round(seconds * 1e9)
    pose = replace(seen.pose, stamp_ns=seen.pose.stamp_ns + step)
    return replace(seen, stamp_ns=seen.stamp_ns + step, pose=pose)


def test_what_a_drone_doubts_is_published(two_rtk):
    fleet, updates = two_rtk.together()
    name, seen, update = updates[-1]
    before = {one.robot_id: one.covariance[0, 0] for one in update.estimates}
    doubt = np.array([np.diag([4.0, 1.0])] + [np.zeros((2, 2))] * (len(seen.labels) - 1))
    after = fleet.update(name, moved(replace(seen, doubt=doubt), 0.1))
    robot = after.names[seen.labels[0]]
    for one in after.estimates:
        more = one.covariance[0, 0] - before[one.robot_id]
        assert more == pytest.approx(4.0 if one.robot_id == robot else 0.0, abs=0.01)


def test_boxes_that_contradict_a_robot_do_not_move_it_and_are_released(two_rtk):
    fleet, updates = two_rtk.together()
    name, seen, update = updates[-1]
    robot = update.names[seen.labels[0]]
    (before,) = (one.position for one in update.estimates if one.robot_id == robot)
    pixels = seen.pixels.copy()
    pixels[0] += 150.0
    for k in range(10):
        update = fleet.update(name, moved(replace(seen, pixels=pixels), 0.1 * (k + 1)))
        (after,) = (one.position for one in update.estimates if one.robot_id == robot)
        assert np.linalg.norm(after - before) < 0.05
    assert seen.labels[0] not in update.names


def with_leg(seen, track):
    """Return a sighting with a box of a track that no drone has confirmed."""
    return replace(
        seen,
        labels=(*seen.labels, ""),
        tracks=(*seen.tracks, track),
        class_ids=(*seen.class_ids, seen.class_ids[0]),
        pixels=np.concatenate([seen.pixels, [[100.0, 60.0]]]),
        doubt=np.concatenate([seen.doubt, np.zeros((1, 2, 2))]),
    )


def test_boxes_of_no_robot_move_nothing(two_rtk):
    """A leg of one drone in its image: short tracks that are never confirmed.

    Until robots are confirmed they have the white noise of an image's pose in common with it.
    """
    without = two_rtk.together()[1]
    fleet = Fleet(two_rtk.configs, two_rtk.local)
    for k, (name, seen, expected) in enumerate(without):
        shown = with_leg(seen, 10**6 + k // 20) if name == "b" else seen
        update = fleet.update(name, shown)
        found = {one.robot_id: one for one in update.estimates}
        for one in expected.estimates:
            assert np.linalg.norm(found[one.robot_id].position - one.position) < 0.001


def test_a_robot_that_returns_elsewhere_gets_a_record_of_its_own(two_rtk):
    """The drone's own estimator took it for another one that the other drone still sees."""
    fleet, updates = two_rtk.together()
    name, seen, update = updates[-1]
    robot, tracks = update.names[seen.labels[0]], (10**6, *seen.tracks[1:])
    (before,) = (one.position for one in update.estimates if one.robot_id == robot)
    pixels = seen.pixels.copy()
    pixels[0] += 150.0
    for k, label in enumerate(("", "", seen.labels[0])):
        told = replace(seen, labels=(label, *seen.labels[1:]), tracks=tracks, pixels=pixels)
        update = fleet.update(name, moved(told, 0.1 * (k + 1)))
    (after,) = (one.position for one in update.estimates if one.robot_id == robot)
    assert np.linalg.norm(after - before) < 0.05
    assert update.names.get(seen.labels[0]) != robot
    assert len(fleet.table.robots) == 4


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"noise.latency_s": 0.1}, "drone b: noise.latency_s must be 0"),
        ({"method": "single"}, "method must be filter, not single"),
    ],
)
def test_what_a_fleet_cannot_do_is_refused(settings, words):
    with pytest.raises(ConfigError, match=words):
        refuse_unable("b", estimator_config(settings))
    with pytest.raises(ConfigError, match="share must lie within 0 to 1, not 2"):
        Fleet({"a": estimator_config({})}, LocalMap(MapDatum(0.2, -1.0, 0.0)), 2.0)
