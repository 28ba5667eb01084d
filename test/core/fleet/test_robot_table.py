# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Records and filter keep step: robots begin, end, come back, and outlast a filter's new start."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.robot_table import RobotTable
from aerial_gnss_ros.core.models.platform_model import COUNT

SECOND_NS = 1_000_000_000


@pytest.fixture
def seen(two_rtk):
    """Return the last sighting of drone a."""
    return two_rtk.sightings["a"][-1]


@pytest.fixture
def table(two_rtk):
    drones = [Drone(name, config) for name, config in two_rtk.configs.items()]
    return RobotTable(drones, [*two_rtk.configs.values()], 0.5)


def begun(table, flown, seen):
    """Let all boxes of an image of drone a begin robots."""
    view = table.look(0, seen, flown.local)
    table.begin(0, seen, view, [*range(len(seen.labels))])
    table.settle()


def test_each_box_begins_a_robot_with_the_drone_s_label(table, two_rtk, seen):
    begun(table, two_rtk, seen)
    assert [robot.labels for robot in table.robots] == [{0: label} for label in seen.labels]
    assert len(table.state.joint) == len(table.robots) == 3
    kept = table.robots[1], table.state.joint.robots[1].copy()
    table.drop([0, 2])
    assert table.robots == [kept[0]]
    np.testing.assert_array_equal(table.state.joint.robots, kept[1][None])


def test_a_robot_ends_by_its_class_and_one_that_nobody_has_confirmed_soon(table, two_rtk, seen):
    begun(table, two_rtk, seen)
    tracks, now_ns = two_rtk.configs["a"].tracks, seen.pose.stamp_ns
    table.robots[1].labels.clear()
    for unseen_s, ended in ((0.9, []), (tracks.confirm_window_s + 0.1, [1])):
        assert table.ended(now_ns + round(unseen_s * 1e9)) == ended
    assert table.ended(now_ns + round((tracks.coast_s + 0.1) * 1e9)) == [0, 1, 2]


@pytest.mark.parametrize("north_m", [0.5, 50.0])
def test_a_robot_that_comes_back_is_its_new_track_unless_it_is_elsewhere(
    table, two_rtk, seen, north_m
):
    begun(table, two_rtk, seen)
    old, new = table.robots[:2]
    new.labels, new.began_ns = {}, old.last_seen_ns + SECOND_NS
    table.state.joint.robots[1, :2] = table.state.joint.robots[0, :2] + (0.0, north_m)
    back, label = table.resume(0, 0, 1), seen.labels[0]
    assert back is (north_m < 1.0)
    assert (new.labels, old.labels) == (({0: label}, {0: label}) if back else ({}, {}))


def test_robots_outlast_a_new_start_of_the_filter_and_are_one_as_drones_agree(table, two_rtk, seen):
    begun(table, two_rtk, seen)
    first, second, third = table.robots
    first.labels, second.labels, third.labels = {0: "x", 1: "y"}, {0: "z"}, {1: "w"}
    table.restart(1, SimpleNamespace(matched=[("v", 0, "z")]))
    assert (table.robots, third.labels) == ([], {})
    assert (first.labels, second.labels) == ({0: "x"}, {0: "z", 1: "v"})
    before = table.state
    again = replace(seen, labels=("z", "x", "u"))
    begun(table, two_rtk, again)
    assert table.state is not before
    assert table.robots[:2] == [second, first]
    assert third not in table.robots


def test_a_filter_begins_with_what_is_known_of_a_fault(table, two_rtk, seen):
    wrong = table._drones[1]
    wrong.fault, wrong.assumed = SimpleNamespace(variances=np.zeros(COUNT)), np.full(COUNT, 0.25)
    begun(table, two_rtk, seen)
    np.testing.assert_allclose(table.state.platform(1)[0], 0.25)
