# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Late, lost and disordered sightings give the state of a flight in which none was."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.history import FAILED, TOO_LATE, TUNING, History
from aerial_gnss_ros.core.fleet.outbox import SentSighting

pytestmark = pytest.mark.flights

SECOND_NS = 10**9
BEGIN_NS = 1_700_000_000 * SECOND_NS


@dataclass
class Log:
    """Stands for a fleet: notes the order in which it is given sightings."""

    robots: list = field(default_factory=list)
    done: list = field(default_factory=list)

    def update(self, name, seen, publish=True):
        self.done.append((seen.pose.stamp_ns, name))
        if seen.fails:
            raise ValueError("of no use")
        return publish


def sent(seconds, drone="a", session=1, number=0, fails=False):
    stamp_ns = BEGIN_NS + round(seconds * SECOND_NS)
    seen = SimpleNamespace(pose=SimpleNamespace(stamp_ns=stamp_ns), fails=fails)
    return SentSighting(drone, session, number, 0, seen)


def seconds(log):
    return [(stamp_ns - BEGIN_NS) / SECOND_NS for stamp_ns, _ in log.done]


class Clock:
    """A clock that a test sets."""

    def __init__(self):
        self.ns = 0

    def __call__(self):
        return self.ns


def made(fleet, *drones):
    """Return a history, and its clock."""
    clock = Clock()
    return History(fleet, drones, clock), clock


def fly(history, clock, arrivals, step_s=0.1):
    """Give sightings at their times of arrival, s, and let everything be applied."""
    arrivals = sorted(arrivals, key=lambda one: one[0])
    now_s, place = 0.0, 0
    while place < len(arrivals) or history.waiting:
        while place < len(arrivals) and arrivals[place][0] <= now_s:
            history.add(arrivals[place][1])
            place += 1
        clock.ns = round(now_s * SECOND_NS)
        history.advance()
        now_s += step_s


@given(
    st.lists(st.tuples(st.integers(0, 1500), st.floats(0.0, 60.0)), min_size=1, max_size=60),
    st.integers(0, 2**31),
)
@settings(max_examples=150, deadline=None)
def test_whatever_comes_within_a_minute_is_applied_at_its_time(scenes, seed):
    drones = np.random.default_rng(seed).choice(["a", "b", "c"], len(scenes))
    told = [
        sent(scene / 10.0, str(drone), 1, number)
        for number, ((scene, _), drone) in enumerate(zip(scenes, drones, strict=True))
    ]
    history, clock = made(Log(), "a", "b", "c")
    arrivals = [(s / 10.0 + delay, one) for (s, delay), one in zip(scenes, told, strict=True)]
    fly(history, clock, arrivals)
    assert sum(history.refused.values()) == 0
    order = sorted((one.sighting.pose.stamp_ns, one.drone) for one in told)
    assert sorted(history.fleet.done) == order
    assert history.fleet.done == order


def test_it_goes_back_at_most_twice_a_second_and_the_newest_do_not_wait():
    history, clock = made(Log(), "a", "b")
    returns, newest = [], []
    for k in range(100):  # b comes 2 s late
        history.add(sent(k / 10.0, "a", 1, k))
        if k >= 20:
            history.add(sent(k / 10.0 - 2.0, "b", 1, k))
        clock.ns = BEGIN_NS + k * SECOND_NS // 10
        history.advance()
        returns.append(history.returned)
        newest.append(seconds(history.fleet)[-1])
    assert newest == [k / 10.0 for k in range(100)]
    assert all(later - now <= 2 for now, later in zip(returns, returns[10:], strict=False))
    assert returns[-1] == 16
    assert history.applied < 6.5 * 180


def test_the_longer_it_takes_the_longer_until_the_next_time():
    class Slow(Log):
        def update(self, name, seen, publish=True):
            clock.ns += SECOND_NS // 100
            return super().update(name, seen, publish)

    history, clock = made(Slow(), "a", "b")
    for k in range(600):
        history.add(sent(k / 10.0, "a", 1, k))
    history.advance()
    for k in range(2):
        history.add(sent(1.0, "b", 1, k))
        history.advance()  # takes some 5.9 s
    assert (history.returned, history.waiting) == (1, 1)
    clock.ns += 5 * SECOND_NS
    history.advance()
    assert history.returned == 1
    clock.ns += SECOND_NS
    history.advance()
    assert (history.returned, history.waiting) == (2, 0)


def test_what_is_older_than_the_history_is_refused():
    history, clock = made(Log(), "a", "b")
    assert history.add(sent(0.0))
    clock.ns = 0
    history.advance()
    assert history.add(sent(100.0, number=1))
    assert not history.add(sent(34.9, "b"))
    assert history.add(sent(35.1, "b", number=1))
    clock.ns = SECOND_NS
    history.advance()
    assert history.refused == {TOO_LATE: 1}
    assert seconds(history.fleet) == [0.0, 35.1, 100.0]


def test_what_waits_until_the_history_has_moved_on_is_refused():
    history, clock = made(Log(), "a", "b")
    for k in range(66):
        history.add(sent(float(k), "a", 1, k))
    clock.ns = 0
    history.advance()
    history.add(sent(10.5, "b", 1, 0))
    clock.ns = 1
    history.advance()  # goes back, and pauses
    history.add(sent(1.5, "b", 1, 1))
    history.add(sent(120.0, "a", 1, 99))
    clock.ns = 2
    history.advance()
    clock.ns = 10 * SECOND_NS
    history.advance()
    assert history.refused == {TOO_LATE: 1}
    assert history.waiting == 0


def test_memory_is_bounded():
    history, clock = made(Log(), "a")
    for k in range(3000):
        history.add(sent(k / 10.0, "a", 1, k))
        clock.ns = k
        history.advance()
    assert len(history._copies) <= TUNING.kept_s / TUNING.copied_s + 2
    assert len(history._known) <= (TUNING.kept_s + TUNING.copied_s) * 10 + 2


@pytest.mark.parametrize("late", [False, True])
def test_what_fails_leaves_nothing_behind(late):
    history, clock = made(Log(), "a")
    bad = sent(1.5, "a", 1, 99, fails=True)
    if not late:
        history.add(bad)
    for k in range(30):
        history.add(sent(k / 10.0, "a", 1, k))
    clock.ns = 0
    history.advance()
    if late:
        history.add(bad)
        clock.ns = SECOND_NS
        history.advance()
    assert history.refused == {FAILED: 1}
    assert [str(one) for one in history.failures] == ["of no use"]
    assert seconds(history.fleet) == [k / 10.0 for k in range(30)]


@pytest.mark.parametrize(("last", "count"), [(False, 30), (True, 0)])
def test_only_what_is_newest_is_published(last, count):
    history, _ = made(Log(), "a")
    for k in range(30):
        history.add(sent(k / 10.0, "a", 1, k))
    if last:  # what goes on from the last copy has applied nothing that is newest
        history.add(sent(4.0, "a", 1, 99, fails=True))
    published = [update for _, update in history.advance()]
    assert published == [False] * (count - 1) + [True] * bool(count)


def test_it_can_begin_again_with_another_fleet():
    history, clock = made(Log(), "a")
    for k in range(20):
        history.add(sent(k / 10.0, "a", 1, k))
    clock.ns = 0
    history.advance()
    history.start_again(Log(), ["a", "b"])
    history.add(sent(0.05, "b"))
    clock.ns = 1
    history.advance()
    assert seconds(history.fleet) == sorted([0.05, *(k / 10.0 for k in range(20))])


@pytest.fixture(scope="module")
def thinned(fleet_of):
    """Two drones with every third image, the sightings as sent, and the fleet without losses."""
    flown = fleet_of(duration=6.0, images=10.0, seed=5)
    told = [
        SentSighting(name, 1, number, 0, seen)
        for name, of in flown.sightings.items()
        for number, seen in enumerate(of[::3])
    ]
    fleet = Fleet(flown.configs, flown.local)
    for one in sorted(told, key=lambda s: (s.sighting.pose.stamp_ns, s.drone)):
        update = fleet.update(one.drone, one.sighting)
    return flown, told, fleet, update


def bits(fleet):
    mean, P, order = fleet.table.state.whole()
    names = [(r.name, r.labels, r.tracks, r.began_ns) for r in fleet.table.robots]
    return mean.tobytes(), P.tobytes(), order, names


@given(data=st.data())
@settings(
    max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_state_and_names_after_catching_up_are_those_of_the_lossless_flight(thinned, data):
    flown, told, fleet, _ = thinned
    delays = data.draw(
        st.lists(st.sampled_from([0.0, 0.3, 2.0, 5.0, 60.0]), min_size=len(told),
                 max_size=len(told))
    )  # fmt: skip
    history, clock = made(Fleet(flown.configs, flown.local), "a", "b")
    begin_ns = min(one.sighting.pose.stamp_ns for one in told)
    fly(
        history,
        clock,
        [
            ((one.sighting.pose.stamp_ns - begin_ns) / SECOND_NS + delay, one)
            for one, delay in zip(told, delays, strict=True)
        ],
    )
    assert sum(history.refused.values()) == 0
    assert bits(history.fleet) == bits(fleet)


def test_the_names_of_a_restarted_drone_are_other_robots(thinned):
    flown, told, fleet, update = thinned
    half = len([one for one in told if one.drone == "a"]) // 2

    def restarted(one):
        if one.drone != "a" or one.sequence < half:
            return one
        seen = one.sighting
        seen = replace(seen, labels=seen.labels[::-1], tracks=seen.tracks[::-1])
        return SentSighting("a", 2, one.sequence - half, 0, seen)

    history, clock = made(Fleet(flown.configs, flown.local), "a", "b")
    fly(history, clock, [(0.0, one) for one in told if one.sequence < half])
    before = list(history.fleet.table.robots)
    assert all(0 in robot.labels for robot in before)
    history.add(restarted(next(s for s in told if s.drone == "a" and s.sequence == half)))
    clock.ns = 10**12
    history.advance()
    assert not any(0 in robot.labels or robot.refused.get(0) for robot in before)
    fly(history, clock, [(2e3, restarted(one)) for one in told if one.sequence > half])
    places = {one.robot_id: (one.latitude, one.longitude) for one in update.estimates}
    found = history.fleet.update(told[-1].drone, told[-1].sighting).estimates
    assert len(found) == len(places)
    for one in found:
        north = (one.latitude - places[one.robot_id][0]) * 6.37e6
        east = (one.longitude - places[one.robot_id][1]) * 6.2e6
        assert math.hypot(east, north) < 1.0
    assert {r.name for r in history.fleet.table.robots} == {r.name for r in fleet.table.robots}
