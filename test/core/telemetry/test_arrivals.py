# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages with stamps far off wait, and are let in or refused when it is known what they are."""

from __future__ import annotations

from collections import Counter

import pytest

from aerial_gnss_ros.core.telemetry import arrivals
from aerial_gnss_ros.core.telemetry.arrivals import Arrivals
from aerial_gnss_ros.core.telemetry.input_status import MessageCounter
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision, Verdict
from aerial_gnss_ros.core.values.events import Events

FAR_S = 100.0
"""Stamps from here on are far off until they are believed."""


INPUTS = ("fix", "gimbal", "detections", "camera_info", "reference_buoy")


class Judge:
    """Stands in for the clock: a test says what stamps are."""

    held, needed = ("camera_info",), ("fix", "gimbal")

    def __init__(self):
        self.believed = set()
        self.found = None
        self.quiet, self.led = (), ()
        self.elsewhere = False

    def judge(self, name, stamp_ns):
        """Return what a stamp is."""
        if stamp_ns < FAR_S * 1e9:
            return Verdict.RETURNS if self.elsewhere else Verdict.GOES_ON
        if name in self.believed:
            return Verdict.GOES_ON
        return Verdict.ELSEWHERE if self.elsewhere else Verdict.FAR_OFF

    def apart_s(self, _name):
        """Return how far off it is."""
        return FAR_S

    def decision(self, _name):
        """Return what far-off stamps turned out to be."""
        return self.found

    def believe(self, decision):
        """Take in a decision."""
        self.believed |= set(decision.moved)
        self.found = None

    def goes_on(self, name):
        """Take in that an input had paused."""
        self.believed.add(name)

    def silent(self):
        """Return the inputs that had paused."""
        return self.quiet

    def leads(self, name):
        """Return whether an input leads."""
        return name in self.led

    def tick(self, _now_ns):
        """Take in the node's time."""


class Door:
    """Arrivals, and what they let in."""

    def __init__(self):
        self.clock, self.log, self.dropped, self.got = Judge(), Events(), Counter(), []
        self.tallies = {name: MessageCounter() for name in INPUTS}
        self.leads = 0
        self.arrivals = Arrivals(
            self.clock, self.tallies, self.dropped, self.log, self.got.append, self._lead
        )

    def _lead(self):
        self.leads += 1

    def send(self, *messages):
        """Send messages of inputs stamped at times, s; return what is let in from then on."""
        self.got.clear()
        for name, t in messages:
            keep = lambda name=name, t=t: self.got.append((name, t))  # noqa: E731
            self.arrivals.receive(name, round(t * 1e9), keep)
        return self.got


def test_messages_whose_stamps_go_on_are_let_in_at_once_and_others_wait():
    door = Door()
    assert door.send(("fix", 1.0), ("fix", 200.0), ("gimbal", 1.0)) == [
        ("fix", 1.0),
        ("gimbal", 1.0),
    ]
    assert (door.tallies["fix"].bad, door.tallies["gimbal"].bad) == (1, 0)
    assert door.tallies["fix"].trouble == "its stamp is 100.0 s ahead of those before"
    assert door.log.drain() == []


@pytest.mark.parametrize(("time_reset", "let_in"), [(True, ["fix", "gimbal"]), (False, ["fix"])])
def test_what_waits_is_let_in_in_its_order_once_it_is_believed(time_reset, let_in):
    """All of it when time began time_reset, else that of the input whose clock was set."""
    door = Door()
    door.send(("gimbal", 200.0), ("fix", 200.0))
    decision = door.clock.found = Decision(
        time_reset, ("fix", "gimbal") if time_reset else ("fix",)
    )
    waited = [("gimbal", 200.0), ("fix", 200.0), ("fix", 201.0)]
    assert door.send(("fix", 201.0)) == [decision, *(one for one in waited if one[0] in let_in)]
    assert door.tallies["fix"].bad == 0
    assert door.tallies["gimbal"].bad == (0 if time_reset else 1)


@pytest.mark.parametrize("stamp_s", [2.0, 300.0], ids=["returns", "is elsewhere"])
def test_what_waits_is_refused_when_stamps_return_or_are_elsewhere_again(stamp_s):
    door = Door()
    door.send(("detections", 200.0), ("fix", 200.0), ("detections", 200.1))
    door.clock.elsewhere = True
    assert door.send(("detections", stamp_s)) == ([("detections", 2.0)] if stamp_s == 2.0 else [])
    assert door.dropped == {arrivals.WRONG_STAMP: 2}
    (words,) = door.log.drain()
    assert words.startswith("2 messages on detections refused: stamped 100.0 s ahead of those")


def test_what_still_waits_in_the_end_is_refused_once_for_each_input():
    door = Door()
    door.send(("fix", 200.0), ("detections", 200.0), ("fix", 200.1))
    door.arrivals.flush()
    assert [one.split(" refused")[0] for one in door.log.drain()] == [
        "2 messages on fix", "1 message on detections",
    ]  # fmt: skip
    assert door.dropped == {arrivals.WRONG_STAMP: 1}
    door.arrivals.flush()
    assert door.log.drain() == []


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("fix", "fix.stamp to arrival."),
        ("detections", "the camera's driver."),
        ("reference_buoy", "check its driver."),
    ],
)
def test_a_stamp_that_nobody_filled_in_is_refused_and_reported_once(name, advice):
    door = Door()
    assert door.send((name, 0.0), (name, 0.0), (name, 1e-9)) == [
        (name, 1e-9)
    ]  # time may begin at 0
    assert door.tallies[name].bad == 2
    assert door.dropped == ({arrivals.NO_STAMP: 2} if name == "detections" else {})
    (words,) = door.log.drain()
    assert words.startswith(f"Messages on {name} are refused: their stamp is 0")
    assert words.endswith(advice)


def test_what_holds_until_replaced_needs_no_stamp():
    door = Door()
    assert door.send(("camera_info", 0.0)) == [("camera_info", 0.0)]
    assert (door.tallies["camera_info"].bad, door.log.drain()) == (0, [])


def test_a_pause_that_ends_lets_in_what_waits():
    door = Door()
    door.send(("fix", 200.0))
    door.arrivals.tick(0)
    assert door.got == []
    door.clock.quiet = ("fix",)
    door.arrivals.tick(0)
    assert door.got == [("fix", 200.0)]
    assert door.tallies["fix"].bad == 0


@pytest.mark.parametrize(
    ("led", "told"),
    [
        ((), 0),
        (("fix",), 1),
        (("gimbal", "fix"), 1),
        (("fix", "detections"), 0),
        (("camera_info",), 0),
    ],
    ids=["silent", "one", "several", "images, too", "not needed"],
)
def test_telemetry_that_leads_images_from_now_on_is_told(led, told):
    door = Door()
    door.send(*((name, 200.0) for name in (*led, "fix")))
    door.clock.quiet = tuple({*led, "fix"})
    door.clock.led = led
    door.arrivals.tick(0)
    assert door.leads == told
    words = door.log.drain()
    assert len(words) == told
    if told:
        assert (
            "100.0 s farther ahead of their arrival than before, those of images are not"
            in words[0]
        )


def test_the_oldest_of_too_many_is_refused(monkeypatch):
    monkeypatch.setattr(arrivals, "MAX_HELD", 3)
    door = Door()
    door.send(*(("fix", 200.0 + i) for i in range(5)))
    door.clock.quiet = ("fix",)
    door.arrivals.flush()
    assert door.got == [("fix", 202.0), ("fix", 203.0), ("fix", 204.0)]
    assert door.tallies["fix"].bad == 2
