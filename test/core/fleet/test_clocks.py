# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A clock that differs shows in robots that move, and in no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.clocks import NO_OFFSET, TUNING, ClockOffset, clock_offset
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY


@pytest.fixture(scope="module")
def swimming(fleet_of):
    """Two drones with RTK over three robots that swim."""
    return fleet_of(noises=("rtk", "rtk"), speed=0.5, seed=21, duration=14.0)


def late(flown, seconds):
    """Return the flight with the second drone's clock ahead."""
    step = round(seconds * 1e9)
    moved = [
        replace(s, stamp_ns=s.stamp_ns + step,
                pose=replace(s.pose, stamp_ns=s.pose.stamp_ns + step))
        for s in flown.sightings["b"]
    ]  # fmt: skip
    return replace(flown, sightings=flown.sightings | {"b": moved})


@pytest.mark.parametrize("seconds", [0.25, -0.15, 0.0])
def test_by_how_much_a_clock_differs_is_found_and_said(swimming, seconds):
    _, updates = late(swimming, seconds).together()
    last = {name: update.report.clock for name, _, update in updates}
    assert last["b"].sigma_s < 0.03
    assert last["b"].ahead_s == pytest.approx(seconds, abs=0.06)
    assert last["a"].ahead_s == pytest.approx(-last["b"].ahead_s, abs=0.02)
    assert last["b"].said == last["a"].said == (seconds != 0.0)
    of = {error.name: error.value for error in updates[-1][2].platform}
    assert of["b clock"] == pytest.approx(last["b"].ahead_s, abs=0.01)
    assert "a clock" not in of


def test_robots_that_stay_tell_nothing(two_rtk):
    _, updates = two_rtk.together()
    clock = updates[-1][2].report.clock
    assert clock.sigma_s > 0.5 * TUNING.sigma_s
    assert not clock.said


def test_a_large_offset_that_is_sure_is_said():
    assert ClockOffset(-0.3, 0.02).said
    assert ClockOffset(-0.3, 0.02).words == "its clock is 0.30 s behind the others'"
    assert ClockOffset(0.3, 0.02).words == "its clock is 0.30 s ahead of the others'"
    assert ClockOffset(0.54, 0.04).words == "its clock is 0.54 s or more ahead of the others'"
    assert not ClockOffset(0.3, 0.1).said
    assert not ClockOffset(0.06, 0.004).said
    assert ClockOffset(0.06, 0.002).said
    assert not NO_OFFSET.said


@pytest.mark.parametrize(
    ("clocks", "expected"),
    [([0.0, 0.4], [-0.4, 0.4]), ([0.0, 0.1, 0.5], [-0.1, 0.0, 0.4]),
     ([0.0, 0.1, 0.2, 0.9], [-0.15, -0.05, 0.05, 0.75])],
)  # fmt: skip
def test_an_offset_is_that_to_the_other_or_to_the_median(clocks, expected):
    state = SharedState([np.diag([1.0, 1.0, 1.0, *[0.1] * 5, 0.04])] * len(clocks), 0.5)
    for drone, clock in enumerate(clocks):
        state.assume(drone, np.array([0.0] * LATENCY + [clock]))
    found = [clock_offset(state, drone, len(clocks)) for drone in range(len(clocks))]
    assert [one.ahead_s for one in found] == pytest.approx(expected)
    assert found[0].sigma_s == pytest.approx({2: 0.2828, 3: 0.2828, 4: 0.2449}[len(clocks)], 1e-3)
    assert clock_offset(SharedState([np.eye(COUNT)], 0.5), 0, 1) is NO_OFFSET


def test_robots_come_back_from_a_drones_time_as_they_were(swimming):
    fleet, _ = late(swimming, 0.2).together()
    state, second = fleet.table.state, fleet._drones[1]
    state.activate(1)
    before, P = state.joint.robots.copy(), state.whole()[1]
    state._moves[:] = True, True, False
    velocities = state._velocities
    assert np.abs(velocities).max() > 0.01
    state._show()
    shown = state.joint.robots.copy()
    clock = state.joint.mean[LATENCY]
    np.testing.assert_allclose(shown[:, :2], before[:, :2] - clock * velocities)
    state.settle()
    np.testing.assert_allclose(state.joint.robots, before)
    np.testing.assert_allclose(state.whole()[1], P, atol=1e-9)
    assert second.stationary[LATENCY, LATENCY] == pytest.approx(TUNING.sigma_s**2)
