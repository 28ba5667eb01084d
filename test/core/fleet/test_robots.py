# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of the fleet's robots, and records of robots that turn out to be one."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.fleet.robots import FleetRobot, Names


def robot(began, drone, label, doubt=0.0):
    made = FleetRobot("aqua", began, began, "", {drone: label})
    made.measured(drone, began, doubt * np.eye(2))
    return made


def test_a_drone_s_own_name_is_used_where_it_is_free():
    names = Names()
    assert names.issue(robot(1, 0, "aqua_1")) == "aqua_1"
    assert names.issue(robot(2, 1, "aqua_1")) == "aqua_2"
    assert names.issue(robot(3, 1, "aqua_2")) == "aqua_3"
    assert names.issue(robot(4, 1, "aqua_7")) == "aqua_7"


def test_names_of_a_fleet_that_begins_anew_go_on():
    names = Names()
    former = {(0, "aqua_1"): "aqua_5", (1, "aqua_4"): "aqua_5", (1, "aqua_1"): "aqua_2"}
    names.follow({"aqua_5", "aqua_2", "aqua_9"}, former)
    assert names.issue(robot(1, 1, "aqua_1")) == "aqua_2"
    assert names.issue(robot(2, 1, "aqua_4")) == "aqua_5"
    assert names.issue(robot(3, 0, "aqua_1")) == "aqua_1"  # the other record has its name
    assert names.issue(robot(4, 0, "aqua_9")) == "aqua_3"  # was another robot
    assert names.taken == {"aqua_1", "aqua_2", "aqua_3", "aqua_5", "aqua_9"}


def test_robots_that_are_one_keep_the_older_name_and_both_labels():
    for younger_first in (False, True):
        old, new = robot(10, 0, "aqua_1", 1.0), robot(20, 1, "aqua_3", 4.0)
        old.name, new.name = "first", "second"
        one, other = (new, old) if younger_first else (old, new)
        one.join(other)
        assert one.name == "first"
        assert one.labels == {0: "aqua_1", 1: "aqua_3"}
        assert (one.began_ns, one.last_seen_ns) == (10, 20)
        assert one.seen_ns == {0: 10, 1: 20}
        np.testing.assert_array_equal(one.widening(20), 4.0 * np.eye(2))


def test_a_name_is_kept_whichever_has_one():
    old, new = robot(10, 0, "aqua_1"), robot(20, 1, "aqua_3")
    new.name = "second"
    old.join(new)
    assert old.name == "second"


def test_seen_within_ends_after_its_time():
    one = robot(1000, 0, "aqua_1")
    assert one.seen_within(1500, 500) == {0}
    assert one.seen_within(1501, 500) == set()
    np.testing.assert_array_equal(FleetRobot("aqua", 0, 0).widening(0), np.zeros((2, 2)))


def test_a_robot_that_is_elsewhere_for_another_drone_may_be_there():
    one, second = robot(0, 0, "aqua_1", 1.0), 10**9
    for k in range(5):
        one.note_rival(np.array([3.0, 0.0]), k * second)
        assert one.contradicted(k * second) == (k >= 3)
    np.testing.assert_array_equal(one.widening(4 * second), np.diag([10.0, 1.0]))
    one.note_rival(None, 5 * second)
    np.testing.assert_array_equal(one.widening(5 * second), np.eye(2))
    one.note_rival(np.array([3.0, 0.0]), 6 * second)
    assert not one.contradicted(8 * second)
    assert one.contradicted(9 * second)
