# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots of two drones become one when that is sure for a while, and not before."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.matching import TUNING, RobotMatching
from aerial_gnss_ros.simulation.sensors import START_NS


def merged_at(flown):
    """Return the seconds at which each robot of the fleet came to have two labels."""
    fleet, updates = flown.together()
    found = {}
    for name, seen, update in updates:
        if name == "b":
            for fleet_name in update.names.values():
                found.setdefault(fleet_name, (seen.stamp_ns - START_NS) * 1e-9)
    return fleet, found


def test_robots_of_both_drones_are_one_after_a_second_and_never_two(two_rtk):
    fleet, found = merged_at(two_rtk)
    assert len(fleet.table.robots) == len(found) == 3
    assert all(TUNING.sure_s <= seconds < TUNING.sure_s + 2.0 for seconds in found.values())
    names = {one.robot_id for _, _, u in two_rtk.together()[1] for one in u.estimates}
    assert len(names) == 3  # none was published under a second name meanwhile


def test_a_robot_begun_late_gets_its_name_when_it_is_nobody_else_s(two_rtk):
    fleet, _ = two_rtk.together()
    matching, now_ns = RobotMatching(fleet._drones), 10**18
    robots = fleet.table.robots
    robots[0].name, robots[0].labels = "", {1: "x"}
    robots[1].labels, robots[2].labels = {0: "y"}, {0: "z"}
    robots[0].began_ns = now_ns - 10**9
    assert not matching.nobody_else(0, robots, now_ns)
    assert matching.nobody_else(0, robots[:1], now_ns)
    robots[0].began_ns = now_ns - round(TUNING.unnamed_s * 1e9) - 1
    assert matching.nobody_else(0, robots, now_ns)
    robots[0].began_ns = now_ns - 10**9
    for other in robots[1:]:
        other.class_id = "buoy"
    assert matching.nobody_else(0, robots, now_ns)


def test_robots_of_three_drones_are_one(fleet_of):
    """With a third drone each robot has two candidates, which are the same robot."""
    flown = fleet_of(count=3, noises=("consumer",) * 3, seed=8, duration=7.0)
    fleet, updates = flown.together()
    assert [len(robot.labels) for robot in fleet.table.robots] == [3, 3, 3]
    errors = flown.errors(updates[-1][2].estimates)
    assert sorted(robot for _, robot in errors.values()) == [0, 1, 2]


def test_two_robots_that_a_third_drone_shows_are_never_one(two_rtk):
    fleet, _ = two_rtk.together()
    robots = fleet.table.robots
    joint = fleet.table.state.joint
    joint.robots[1, :2] = joint.robots[0, :2]  # nothing else tells them apart
    robots[0].seen_ns, robots[1].seen_ns = {0: 10**18}, {1: 10**18}
    three = RobotMatching([*fleet._drones, fleet._drones[0]])
    both = [three.update(fleet.table.state, robots[:2], 10**18 + k * 10**9) for k in (0, 1)]
    robots[0].seen_ns[2] = robots[1].seen_ns[2] = 10**18
    three = RobotMatching([*fleet._drones, fleet._drones[0]])
    neither = [three.update(fleet.table.state, robots[:2], 10**18 + k * 10**9) for k in (0, 1)]
    assert neither == [[], []]
    assert both == [[], [(0, 1)]]


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_with_poor_receivers_the_right_robots_become_one(fleet_of, share):
    flown = fleet_of(robots=5, seed=9, share=share, speed=0.2, duration=8.0)
    _, updates = flown.together()
    _, seen, update = updates[-1]
    frame = flown.made["b"].frames()[-1]
    true = flown.made["b"].projected(frame)
    of_a = {}
    last_a = next(s for n, s, _ in reversed(updates) if n == "a")
    true_a = flown.made["a"].projected(flown.made["a"].frames()[-1])
    names_a = next(u.names for n, _, u in reversed(updates) if n == "a")
    for label, pixel in zip(last_a.labels, last_a.pixels, strict=True):
        of_a[names_a[label]] = nearest(true_a, pixel)
    both = 0
    for label, pixel in zip(seen.labels, seen.pixels, strict=True):
        name = update.names.get(label)
        if name in of_a:
            assert of_a[name] == nearest(true, pixel)
            both += 1
    assert both >= 4


def nearest(boxes, pixel):
    """Return the true robot whose box is the nearest to a pixel."""
    return boxes.names[int(np.linalg.norm(boxes.centers - pixel, axis=1).argmin())]
