# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A fleet finds out whether robots stay, by itself."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.simulation.sensors import START_NS

pytestmark = pytest.mark.flights


def told(flown):
    """Return all sightings in order, with the drone."""
    every = [(s.pose.stamp_ns, name, s) for name, of in flown.sightings.items() for s in of]
    return [one[1:] for one in sorted(every, key=lambda one: one[:2])]


def finding(flown):
    """Return a fleet that asks whether robots stay."""
    configs = {
        name: replace(one, tracks=replace(one.tracks, find_moored=True))
        for name, one in flown.configs.items()
    }
    return Fleet(configs, flown.local)


@pytest.fixture(scope="module")
def orbit(fleet_of):
    """Two drones with RTK circle around three robots that stay."""
    return fleet_of(kind="orbit", noises=("rtk", "rtk"), seed=6, height_m=30.0, duration=30.0)


def test_what_stays_makes_all_drones_more_precise(orbit):
    fleet = finding(orbit)
    estimates = [fleet.update(name, seen).estimates for name, seen in told(orbit)]
    swimming = [update.estimates for *_, update in orbit.together()[1]]
    assert fleet.table.staying.law is not None
    assert np.count_nonzero(fleet.table.staying.law.sway) == 3
    assert fleet.table.staying.weights()[1] > 0.99
    sigma, other = (np.mean([one.sigma for one in of[-1]]) for of in (estimates, swimming))
    assert sigma < 0.7 * other
    for one in estimates[-1]:
        apart = orbit.errors([one])[one.robot_id][0]
        assert apart < 3.0 * one.sigma


def test_a_fleet_that_goes_back_gives_the_same_again(orbit):
    fleet, sightings = finding(orbit), told(orbit)
    for name, seen in sightings[:150]:
        fleet.update(name, seen)
    again = copy.deepcopy(fleet)
    for one in (fleet, again):
        for name, seen in sightings[150:200]:
            update = one.update(name, seen)
        last = update.estimates if one is fleet else last  # noqa: F821 - set in the first round
    assert [repr(one) for one in update.estimates] == [repr(one) for one in last]


def test_robots_that_swim_are_published_as_if_nobody_asked(fleet_of):
    flown = fleet_of(speed=0.5, noises=("rtk", "rtk"), seed=3)
    fleet = finding(flown)
    found = [fleet.update(name, seen).estimates for name, seen in told(flown)]
    plain = [update.estimates for *_, update in flown.together()[1]]
    assert fleet.table.staying.law is None
    assert repr(found[-1]) == repr(plain[-1])


def test_a_drone_that_joins_late_finds_the_robots_that_stay(orbit):
    """Its robots become those of the others in both laws."""
    fleet, joins_ns = finding(orbit), START_NS + 20 * 10**9
    for name, seen in told(orbit):
        if name == "a" or seen.pose.stamp_ns >= joins_ns:
            fleet.update(name, seen)
    assert fleet.table.staying.law is not None
    assert [robot.labels.keys() for robot in fleet.table.robots] == [{0, 1}] * 3


def test_a_receiver_that_jumps_makes_it_begin_anew(orbit):
    fleet, sightings = finding(orbit), told(orbit)
    for name, seen in sightings[:150]:
        fleet.update(name, seen)
    before = fleet.table.staying.law
    assert before is not None
    name, seen = sightings[150]
    fleet.update(name, replace(seen, believed=seen.believed + 5.0))
    assert fleet.table.staying.law is not before
    assert fleet.table.staying.weights()[1] < 0.01


def test_a_robot_that_the_other_drone_shows_is_not_missed(orbit):
    """Images of two drones take turns; once both are silent, it may have left."""
    fleet = finding(orbit)
    fleet_sigmas, swimming = {"a": [], "b": []}, orbit.together()[1][-1][2].estimates
    for name, seen in told(orbit):
        estimates = fleet.update(name, seen).estimates
        fleet_sigmas[name].append(np.mean([one.sigma for one in estimates] or [0.0]))
    a, b = (np.mean(of[-25:]) for of in fleet_sigmas.values())
    assert a == pytest.approx(b, rel=0.05)
    assert max(a, b) < 0.75 * np.mean([one.sigma for one in swimming])
    later = fleet.predicted(seen.stamp_ns + 2 * 10**9)
    assert np.mean([one.sigma for one in later]) > 1.5 * b


@pytest.fixture(scope="module")
def one_robot(fleet_of):
    """Two drones with RTK hover on opposite sides of one robot that stays."""
    return fleet_of(noises=("rtk", "rtk"), seed=6, height_m=30.0, duration=20.0, robots=1)


def test_a_single_robot_that_two_drones_show_is_found_to_stay(one_robot):
    fleet = finding(one_robot)
    for name, seen in told(one_robot):
        fleet.update(name, seen)
    assert len(fleet.table.robots) == 1
    assert fleet.table.staying.law is not None
    assert fleet.table.staying.weights()[1] > 0.9


def test_a_single_robot_that_one_drone_shows_is_not_asked_for(one_robot):
    fleet, first = finding(one_robot), [s for name, s in told(one_robot) if name == "a"]
    for seen in first:
        fleet.update("a", seen)
        assert fleet.table.staying.law is None


def test_a_single_robot_of_which_the_other_drone_tells_no_more_is_given_up(one_robot):
    fleet = finding(one_robot)
    for name, seen in told(one_robot):
        if name == "a" or (seen.pose.stamp_ns - START_NS) * 1e-9 < 9.0:
            fleet.update(name, seen)
        if (seen.pose.stamp_ns - START_NS) * 1e-9 < 18.0:
            found = fleet.table.staying.law
    assert found is not None
    assert fleet.table.staying.law is None
