# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A wrong drone is named, followed and acquitted; where nobody knows, both are named."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.fault import FAULTS, Suspicion
from aerial_gnss_ros.core.fleet.fault_search import FaultSearch
from aerial_gnss_ros.simulation.sensors import START_NS

pytestmark = pytest.mark.flights

SECOND = 1_000_000_000


def named(updates):
    """Return when each drone was named first, s, and the sensors of the last reports."""
    first, last = {}, {}
    for _, seen, update in updates:
        report = update.report
        if report.disagrees:
            first.setdefault(report.drone, (seen.stamp_ns - START_NS) * 1e-9)
        last[report.drone] = report.fault
    return first, last


@pytest.mark.parametrize("wrong", ["a", "b"])
def test_a_drone_with_a_wrong_compass_is_named_alone_and_does_no_harm(fleet_of, turned, wrong):
    def spoil(name, estimator):
        return turned(estimator, math.radians(10.0)) if name == wrong else estimator

    flown = fleet_of(noises=("rtk", "rtk"), seed=15, images=10.0, duration=10.0, spoil=spoil)
    fleet, updates = flown.together()
    first, last = named(updates)
    assert [*first] == [wrong]
    assert first[wrong] < 5.0
    assert last == {"a": "", "b": ""} | {wrong: "compass"}
    # They are as good as the right one, and robots keep one name.
    assert [len(robot.labels) for robot in fleet.table.robots] == [2, 2, 2]
    assert len({one.robot_id for _, _, u in updates[60:] for one in u.estimates}) == 3
    right = "ab".replace(wrong, "")
    alone = flown.rms([result.estimates for result in flown.alone[right]], 6.0)
    together = flown.rms([update.estimates for _, _, update in updates], 6.0)
    assert together < 1.5 * alone < 0.2
    for one in updates[-1][2].estimates:
        assert flown.errors([one])[one.robot_id][0] < 4.0 * one.sigma


def test_a_compass_that_fails_in_flight_is_named(fleet_of, turned):
    def spoil(name, estimator):
        return turned(estimator, math.radians(10.0), 6.0) if name == "b" else estimator

    flown = fleet_of(noises=("rtk", "rtk"), seed=16, images=10.0, duration=14.0, spoil=spoil)
    _, updates = flown.together()
    first, last = named(updates)
    assert last == {"a": "", "b": "compass"}
    assert 6.0 < first["b"] < 11.0
    for one in updates[-1][2].estimates:
        assert flown.errors([one])[one.robot_id][0] < 4.0 * one.sigma


def test_with_two_poor_receivers_a_wrong_compass_is_either_s(fleet_of, turned):
    def spoil(name, estimator):
        return turned(estimator, math.radians(12.0)) if name == "b" else estimator

    right = fleet_of(noises=("consumer", "consumer"), seed=18, images=10.0, duration=12.0)
    assert named(right.together()[1]) == ({}, {"a": "", "b": ""})
    wrong = fleet_of(
        noises=("consumer", "consumer"), seed=18, images=10.0, duration=12.0, spoil=spoil
    )
    first, last = named(wrong.together()[1])
    assert {*first} == {"a", "b"}
    assert max(first.values()) < 10.0
    assert last == {"a": "", "b": ""}


def test_with_two_drones_a_wrong_receiver_is_either_s(fleet_of, shifted):
    def spoil(name, estimator):
        return shifted(estimator, 10.0) if name == "b" else estimator

    flown = fleet_of(noises=("rtk", "rtk"), seed=17, images=10.0, duration=8.0, spoil=spoil)
    _, updates = flown.together()
    first, last = named(updates)
    assert {*first} == {"a", "b"}
    assert last == {"a": "", "b": ""}
    for one in updates[-1][2].estimates:
        assert flown.errors([one])[one.robot_id][0] < 3.0 * one.sigma


def test_a_fault_that_the_data_no_longer_show_is_taken_back(two_rtk):
    fleet, _ = two_rtk.together()
    compass = next(one for one in FAULTS if one.sensor == "compass")
    wrong, now_ns = fleet._drones[1], 10**18
    wrong.fault = compass
    wrong.state_receiver(wrong.last)
    search = FaultSearch(fleet._drones, 0.75)
    heading, covariance = fleet.table.state.platform(1)
    assert abs(heading[5]) < 3.0 * math.sqrt(covariance[5, 5]) + math.radians(0.3)
    fleet.table.state.activate(1)
    fleet.table.state.joint.mean[5] = math.radians(10.0)
    assert search.update(fleet.table.state, fleet.table.robots, now_ns) is None
    assert wrong.fault is compass
    fleet.table.state.joint.mean[5] = np.float64(0.0)
    assert search.update(fleet.table.state, fleet.table.robots, now_ns + 10**9) is None
    assert wrong.fault is None


def test_trials_become_rare_while_none_convinces_and_one_that_does_is_soon_confirmed(two_rtk):
    fleet, _ = two_rtk.together()
    search = FaultSearch(fleet._drones, 0.75)
    convincing = SimpleNamespace(suspicion=Suspicion(1, FAULTS[0], 20.0))
    verdicts, tried, found = iter([None] * 5 + [convincing] * 9), [], None
    search._contradicted = lambda _robots, _now_ns: True
    search._snapshots = lambda now_ns: dict.fromkeys(range(1 + (now_ns >= 20 * SECOND)))

    def trial(_snapshots, _stationary):
        tried.append(now / 10.0)
        return next(verdicts)

    search._try = trial
    for now in range(100, 600):
        found = search.update(fleet.table.state, fleet.table.robots, now * SECOND // 10)
        if found is not None:
            break
    pauses = np.diff(tried)
    assert tried[0] == 20.0  # one image alone is no trial, and delays none
    assert (np.diff(pauses[:5]) >= 0.0).all()
    assert pauses[4] > 2.0
    assert pauses[5:].tolist() == [0.5, 0.5]
    assert (found.drone, found.trial) == (1, convincing)


def test_a_drone_alone_is_not_suspected(two_rtk):
    fleet, _ = two_rtk.together()
    fleet.table.state.joint.mean[5] = math.radians(20.0)
    search = FaultSearch(fleet._drones[:1], 0.75)
    assert search.update(fleet.table.state, fleet.table.robots, 10**18) is None
