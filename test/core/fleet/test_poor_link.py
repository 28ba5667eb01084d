# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drones over a link that loses, delays, repeats and reorders what both ends send, or is gone.

A relay of our own stands for the link, with a clock that only it moves on; both ends are those that
fly: outbox, texts, requests, gaps, history. After catching up, robots and names are those of a
flight over a perfect link.
"""

from __future__ import annotations

import heapq
import itertools
import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from aerial_gnss_ros.adapters.fleet_messages import Request, request, request_text
from aerial_gnss_ros.adapters.sighting_messages import sent_sighting, sighting_text
from aerial_gnss_ros.core.fleet.gaps import TUNING as GAPS
from aerial_gnss_ros.core.fleet.outbox import SECOND_NS, Outbox
from aerial_gnss_ros.core.fleet.shore import Shore
from aerial_gnss_ros.simulation.sensors import START_NS

pytestmark = pytest.mark.flights

LASTED_S = 80.0
STEP_S = 0.1
MOST_S = 200.0


@dataclass
class Relay:
    """One direction of a link.

    Attributes:
        rng: decides.
        loss: probability that a message is lost.
        twice: that it comes twice.
        delay_s: least delay, s.
        jitter_s: greatest further delay, s, so messages overtake each other.
        gone_s: beginning and end of an outage, s.
        dropped: number of messages lost.
    """

    rng: np.random.Generator
    loss: float = 0.0
    twice: float = 0.0
    delay_s: float = 0.1
    jitter_s: float = 0.0
    gone_s: tuple[float, float] = (math.inf, math.inf)
    dropped: int = 0
    _under_way: list = field(default_factory=list)
    _order: itertools.count = field(default_factory=itertools.count)

    def send(self, now_s, text, *, surely=False):
        """Take a message."""
        gone = self.gone_s[0] <= now_s < self.gone_s[1]
        if not surely and (gone or self.rng.random() < self.loss):
            self.dropped += 1
            return
        for _ in range(1 + (self.rng.random() < self.twice)):
            at_s = now_s + self.delay_s + self.jitter_s * self.rng.random()
            heapq.heappush(self._under_way, (at_s, next(self._order), text))

    def arrived(self, now_s):
        """Yield the messages that have arrived."""
        while self._under_way and self._under_way[0][0] <= now_s:
            yield heapq.heappop(self._under_way)[2]


class Aboard:
    """What a drone does, as its node does it."""

    def __init__(self, name, sightings, down, up):
        self.outbox, self.down, self.up = Outbox(name), down, up
        self.left, self.again = list(sightings), {}

    def step(self, now_s):
        while self.left and scene_s(self.left[0]) <= now_s:
            seen = self.left.pop(0)
            # Only a later one tells the fleet that one is missing: the last one comes surely.
            self.down.send(now_s, sighting_text(self.outbox.add(seen)), surely=not self.left)
        for text in self.up.arrived(now_s):
            wanted = request(text)
            for first, last in wanted.ranges:
                for one in self.outbox.between(wanted.session, first, last):
                    self.again[one.session, one.sequence] = None
        for session, number in list(self.again)[: round(GAPS.rate_hz * STEP_S)]:
            del self.again[session, number]
            for one in self.outbox.between(session, number, number):
                self.down.send(now_s, sighting_text(one))


def scene_s(seen):
    return (seen.pose.stamp_ns - START_NS) / SECOND_NS


@pytest.fixture(scope="module")
def flight(fleet_of):
    """Two drones for 80 s, as `Flown`, and their sightings, thinned to one a second."""
    made = fleet_of(kind="orbit", duration=LASTED_S, images=2.0, seed=12, speed=0.3, height_m=30.0)
    return made, {name: of[::2] for name, of in made.sightings.items()}


def joined(flight, **trouble):
    """Return the shore and its last result after a flight whose second drone has a poor link."""
    made, sightings = flight
    now_s, rng = 0.0, np.random.default_rng(5)
    shore = Shore(["a", "b"], 0.5, made.made["a"].flight.origin, lambda: round(now_s * SECOND_NS))
    for name in "ab":
        shore.describe(name, name, made.configs[name], None)
    drones = {"a": Aboard("a", sightings["a"], Relay(rng), Relay(rng))}
    drones["b"] = Aboard("b", sightings["b"], Relay(rng, **trouble), Relay(rng, **trouble))
    result, asked_s = None, 0.0
    while True:
        for name, drone in drones.items():
            drone.step(now_s)
            for text in drone.down.arrived(now_s):
                shore.add(name, sent_sighting(text), START_NS + round(now_s * SECOND_NS))
        result = shore.advance() or result
        if now_s - asked_s >= 1.0:
            asked_s = now_s
            for link in shore.links.values():
                wanted = tuple(link.gaps.wanted(round(now_s * SECOND_NS)))
                if wanted:
                    text = request_text(Request(link.drone, link.gaps.session, wanted))
                    drones[link.drone].up.send(now_s, text)
        waits = any(link.gaps.missing for link in shore.links.values()) or shore.history.waiting
        if now_s > LASTED_S + 4.0 and not waits:
            return shore, result, drones["b"].down
        assert now_s < MOST_S, "it does not catch up"
        now_s += STEP_S


def test_the_flight_is_as_long_as_it_says(flight):
    for of in flight[1].values():
        assert scene_s(of[0]) < 2.0
        assert scene_s(of[-1]) > LASTED_S - 1.5


@pytest.fixture(scope="module")
def lossless(flight):
    shore, result, _ = joined(flight)
    assert shore.history.returned == 0
    assert len(result.estimates) == 3
    return shore, result


@pytest.mark.parametrize(
    ("trouble", "dropped"),
    [
        ({"loss": 0.3}, 20),
        ({"delay_s": 2.0}, 0),
        ({"gone_s": (10.0, 70.0)}, 50),
        ({"loss": 0.3, "twice": 0.3, "delay_s": 1.0, "jitter_s": 1.5}, 20),
        ({"loss": 0.3, "delay_s": 2.0, "gone_s": (15.0, 60.0)}, 50),
    ],
    ids=["30 % lost", "2 s late", "60 s outage", "reordered and repeated", "all of it"],
)
def test_after_catching_up_all_is_as_over_a_perfect_link(flight, lossless, trouble, dropped):
    shore, result, down = joined(flight, **trouble)
    assert down.dropped >= dropped
    perfect, expected = lossless
    assert [e.robot_id for e in result.estimates] == [e.robot_id for e in expected.estimates]
    for one, other in zip(result.estimates, expected.estimates, strict=True):
        assert np.hypot(*(one.position - other.position)) < 1e-3
        assert np.allclose(one.covariance, other.covariance, rtol=1e-6)
    for name, link in shore.links.items():
        assert link.gaps.lost == 0
        assert not link.refused
        assert link.update.names == perfect.links[name].update.names
    if "twice" in trouble:
        assert shore.links["b"].gaps.repeated > 0


def test_what_is_gone_for_longer_is_lost_and_counted(flight):
    shore, result, _ = joined(flight, gone_s=(5.0, 76.0))
    assert 0 < shore.links["b"].gaps.lost < 30
    assert len(result.estimates) == 3
