# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whose fault makes the constellations agree."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fault import culprit, probabilities
from aerial_gnss_ros.core.fleet.fault_trial import trials
from aerial_gnss_ros.core.fleet.snapshot import Snapshot
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy


@pytest.fixture(scope="module")
def watched(fleet_of):
    """A function that tries drones whose last poses are spoiled."""
    places = 0.3 * 15.0 * np.array([[0.6, 0.5], [-1.0, 0.2], [0.4, -0.8]])
    flown = {
        sort: fleet_of(noises=(sort,) * 3, count=3, places=places, duration=3.0, seed=14, share=0.5)
        for sort in ("rtk", "consumer")
    }

    def tried(sort, count, wrong=None, spoil=None, robots=3):
        snapshots = {}
        of = flown[sort]
        for number, (name, seen) in enumerate(of.sightings.items()):
            if number >= count:
                break
            one, last = Drone(name, of.configs[name]), seen[-1]
            if name == wrong:
                last = replace(last, pose=spoil(last.pose))
            one.look(last, of.local)
            labels = [label for label in last.labels if label][:robots]
            snapshots[number] = Snapshot(one, labels)
        stationary = [one.drone.stationary for one in snapshots.values()]
        return trials(snapshots, stationary, 0.75)

    return tried


def turned(degrees):
    def spoil(pose):
        rotation = matrix_from_rpy(0.0, 0.0, math.radians(degrees))
        return replace(pose, enu_from_camera=rotation @ pose.enu_from_camera)

    return spoil


def north(metres):
    return lambda pose: replace(pose, latitude=pose.latitude + metres / 6.37e6)


def named(tried):
    found = culprit([one.suspicion for one in tried])
    return None if found is None else (found.drone, found.fault.sensor)


@pytest.mark.parametrize(("wrong", "number"), [("a", 0), ("b", 1)])
@pytest.mark.parametrize("degrees", [10.0, -25.0, 100.0])
def test_two_precise_receivers_tell_whose_compass_is_wrong(watched, wrong, number, degrees):
    tried = watched("rtk", 2, wrong, turned(degrees))
    assert named(tried) == (number, "compass")
    best = max(tried, key=lambda one: one.suspicion.log_ratio)
    assert math.degrees(best.errors[5]) == pytest.approx(-degrees, abs=1.5)
    assert len({label for label, _, _ in best.matched}) == 3


def test_two_poor_receivers_do_not_tell_whose_compass_is_wrong(watched):
    for wrong in "ab":
        assert named(watched("consumer", 2, wrong, turned(10.0))) is None


def test_two_drones_do_not_tell_whose_receiver_is_wrong_and_three_do(watched):
    tried = watched("rtk", 2, "b", north(10.0))
    assert named(tried) is None
    likely = sorted(probabilities([one.suspicion for one in tried]))[-2:]
    assert likely == pytest.approx([0.5, 0.5], abs=0.02)
    for wrong, number in zip("abc", range(3), strict=True):
        assert named(watched("rtk", 3, wrong, north(10.0))) == (number, "receiver")


@pytest.mark.parametrize("sort", ["rtk", "consumer"])
@pytest.mark.parametrize("count", [2, 3])
def test_drones_that_are_right_are_not_suspected(watched, sort, count):
    tried = watched(sort, count)
    assert named(tried) is None
    assert sum(probabilities([one.suspicion for one in tried])) < 0.1


def test_one_robot_agrees_under_many_faults(watched):
    assert named(watched("rtk", 2, "b", turned(10.0), robots=1)) is None
