# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stamps that are wrong, clocks that are set, and time that is reset."""

from __future__ import annotations

import copy
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation.state_file import load
from aerial_gnss_ros.core.telemetry.input_status import InputState
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.core.values.samples import Orientation, Scalar

pytestmark = pytest.mark.flights

DAY = 86_400.0
RATE = 5
"""Images a second."""
NEEDED = ("fix", "gimbal", "height", "detections")
OTHERS = ("attitude", "camera_info", "water_level", "depth")
ALL = (*NEEDED, *OTHERS)
ROBOTS = {"a": (3.0, 22.0), "b": (-12.0, 25.0), "c": (14.0, 34.0)}
NAMES = ["aqua_1", "aqua_2", "aqua_3"]


class Player:
    """Plays a hover with all inputs into an estimator; stamps and the node's clock may be off."""

    def __init__(self, sea, values=None, images=RATE, telemetry=20):
        robots = {name: (lambda _t, place=place: place) for name, place in ROBOTS.items()}
        self.sea, self.images, self.telemetry = sea, images, telemetry
        self.world = sea.World(robots=robots)
        self.engine = sea.estimator({"depth.topics": ["depth"]} | (values or {}))
        self.results = []
        self.t = 0.0

    def send(self, name, t, off=0.0):
        """Send one message, stamped so many seconds off."""
        engine, world = self.engine, self.world
        ns = self.sea.stamp(t + off)
        if name == "detections":
            engine.add_detections(replace(world.frame(t), stamp_ns=ns))
        elif name == "camera_info":
            engine.add_camera(ns, self.sea.camera)
        elif name == "attitude":
            engine.add_attitude(Orientation(ns, np.array([0.0, 0.0, 0.0, 1.0])))
        elif name == "water_level":
            engine.add_water_level(Scalar(ns, 0.0))
        elif name == "depth":
            engine.add_depth("", Scalar(ns, 0.0))
        else:
            getattr(engine, f"add_{name}")(replace(getattr(world, name)(t), stamp_ns=ns))

    def play(self, seconds, off=None, clock=0.0, without=(), steady=None):
        """Go on for so long; `off`: of stamps by input; `clock`: by how much the node's is off.

        `steady`: by how much one that nobody sets is off, None without such.
        """
        off = off or {}
        for i in range(round(seconds * 20)):
            t = self.t + 0.05 * i
            k = round(t * 20)
            for name in ("camera_info", "water_level", "depth", "attitude", *NEEDED):
                rate = self.images if name in ("detections", "camera_info") else self.telemetry
                if k % round(20 / rate) == 0 and name not in without:
                    self.send(name, t, off.get(name, 0.0))
            steady_ns = None if steady is None else round((t + steady) * 1e9)
            self.results += self.engine.advance(self.sea.stamp(t + clock), steady_ns)
        self.t += seconds
        return self

    def end(self):
        """Take what is left; return the results."""
        self.results += self.engine.flush()
        return self.results

    def names(self, since):
        """Return the robots measured in each image stamped later."""
        return [
            [e.robot_id for e in r.estimates if str(e.state) == "confirmed"]
            for r in self.results
            if r.stamp_ns >= self.sea.stamp(since)
        ]

    def reported(self, words):
        return [sentence for sentence in self.engine.events if words in sentence]


@pytest.fixture
def player(sea):
    return lambda *args, **kwargs: Player(sea, *args, **kwargs)


def swaying(flight):
    """Let the drone of a flight sway and turn to and fro."""
    flight.world.drone = lambda t: (4.0 * math.sin(t), 0.0, 30.0 + 2.0 * math.sin(1.5 * t))
    flight.world.rpy_deg = lambda t: (0.0, 60.0, 90.0 + 6.0 * math.sin(2.5 * t))
    return flight


@pytest.fixture(scope="module")
def flown(sea):
    """Return a function that returns a flight after so many seconds in which all was right.

    They are the same in every test: flown once, and copied. A drone hovers, or sways.
    """
    flights = {}

    def after(seconds, sways=False):
        key = seconds, sways
        if key not in flights:
            flights[key] = (swaying if sways else lambda one: one)(Player(sea)).play(seconds)
        return copy.deepcopy(flights[key], {id(sea.camera): sea.camera})

    return after


@pytest.mark.parametrize("off", [DAY, -DAY, 3.0])
@pytest.mark.parametrize("name", [*NEEDED, *OTHERS])
def test_one_wrong_stamp_renames_nobody(flown, name, off):
    flight = flown(3.0)
    before = flight.engine.inputs[name]
    flight.send(name, 3.0, off)
    flight.play(3.0).end()
    assert flight.names(1.0) == [NAMES] * 5 * RATE  # no image is lost either
    assert flight.engine.happened == Counter()
    harmless = off < 0.0 and name in ("camera_info", "water_level", "depth")  # sent long ago
    assert flight.engine.inputs[name].bad - before.bad == (not harmless)
    assert len(flight.reported(f"1 message on {name} refused")) == (not harmless)
    assert flight.engine.dropped == ({"wrong_stamp": 1} if name == "detections" else {})


@pytest.mark.parametrize("off", [DAY, -DAY, 5.0])
@pytest.mark.parametrize("name", [*NEEDED, "attitude", "camera_info"])
def test_one_input_with_wrong_stamps_for_5_s_renames_nobody(flown, name, off):
    flight = flown(6.0).play(2.0, off={name: off})
    harmless = off < 0.0 and name in ("camera_info", "water_level", "depth")
    if not harmless and name != "attitude":  # which is not used
        assert flight.engine.inputs[name].state is InputState.BAD
        assert "its stamp is" in flight.engine.inputs[name].trouble
    flight.play(3.0, off={name: off}).play(4.0).end()
    assert flight.names(12.0) == [NAMES] * 3 * RATE
    assert flight.engine.happened == Counter()
    if name in OTHERS:
        assert flight.names(1.0) == [NAMES] * 14 * RATE


@pytest.mark.parametrize("off", [1.0, 1.8])
@pytest.mark.parametrize("name", NEEDED)
def test_early_stamps_of_one_input_rename_nobody(flown, name, off):
    """Between the last right sample and the first early one the drone would seem to stand."""
    flight = flown(6.0, sways=True).play(2.0, off={name: off})
    assert flight.engine.inputs[name].state is InputState.BAD
    assert "s ahead of those before" in flight.engine.inputs[name].trouble
    flight.play(5.0).end()
    found = {e.robot_id for r in flight.results for e in r.estimates}
    assert (found, flight.names(9.0)) == (set(NAMES), [NAMES] * 4 * RATE)


def test_telemetry_that_comes_to_lead_images_has_latencies_asked_anew(flown):
    """The autopilot's clock is set by a second: images of before told what is no longer so."""
    flight = flown(6.0)
    tracks = flight.engine._tracks
    tracks._doubt.close()
    flight.play(8.0, off=dict.fromkeys(NEEDED[:3], 1.0)).end()
    assert tracks._doubt.open
    (reported,) = flight.reported("Stamps of telemetry")
    assert "1.0 s farther ahead of their arrival than before" in reported


@pytest.mark.parametrize("off", [DAY, -DAY])
@pytest.mark.parametrize("name", ["fix", "detections", "attitude", "camera_info"])
def test_a_wrong_first_stamp_costs_moments(player, name, off):
    flight = player()
    flight.send(name, 0.0, off)
    flight.play(3.0).end()
    assert flight.names(1.0)[-2 * RATE :] == [NAMES] * 2 * RATE
    assert {e.robot_id for r in flight.results for e in r.estimates} == set(NAMES)


@pytest.mark.parametrize("telemetry", [20, 1])
@pytest.mark.parametrize("clock", [True, False])
@pytest.mark.parametrize("back", [100.0, 3.5])
def test_time_that_begins_anew_is_followed_within_a_second(player, telemetry, clock, back):
    """A bag in a loop; the node's clock goes along (`--clock`) or not."""
    flight = player(telemetry=telemetry, values={"height.max_gap": 2.5, "gimbal.max_gap": 2.5})
    flight.t = back
    flight.play(4.0 if back > 4.0 else 3.5, without=OTHERS[:1])
    end, flight.t = flight.t, 0.0
    flight.play(1.15, clock=0.0 if clock else end)
    assert flight.engine.happened["time_went_backward"] == 1
    flight.play(2.85, clock=0.0 if clock else end).end()
    assert flight.engine.happened["time_went_backward"] == 1
    (reported,) = flight.reported("Time went backward by")
    assert (
        "robots get new labels" in reported
    ) == clock  # else the node's clock shows what time passed
    stamps = [r.stamp_ns for r in flight.results]
    again = flight.results[stamps.index(flight.sea.stamp(0.0)) :]
    assert len(again) == 4 * RATE  # nothing of the new pass is lost
    assert not any(r.rejections for r in again[: 3 * RATE + 1])
    names = ["aqua_4", "aqua_5", "aqua_6"] if clock else NAMES
    assert [e.robot_id for e in again[-1].estimates] == names
    assert again[0].stamp_ns == flight.sea.stamp(0.0)


@pytest.mark.parametrize("hours", [3.0, -3.0])
@pytest.mark.parametrize("clock", [True, False])
def test_a_clock_that_steps_for_all_is_followed(flown, hours, clock):
    flight = flown(5.0)
    off = dict.fromkeys((*NEEDED, *OTHERS), 3600.0 * hours)
    seen = len(flight.results)
    flight.play(5.0, off=off, clock=3600.0 * hours if clock else 0.0).end()
    after = [r for r in flight.results[seen:] if abs(r.stamp_ns - flight.sea.stamp(7.5)) > 9e12]
    assert len(after) == 5 * RATE
    assert sum(bool(r.rejections) for r in after) <= RATE
    assert len(after[-1].estimates) == 3


@pytest.mark.parametrize("step", [3600.0, -3600.0])
def test_the_node_s_clock_alone_may_be_set(flown, step):
    flight = flown(5.0).play(5.0, clock=step)
    flight.send("fix", 10.0, DAY)
    flight.play(2.0, clock=step).end()
    assert flight.engine.happened == Counter()
    assert flight.names(6.0) == [NAMES] * 6 * RATE


def test_telemetry_whose_clock_comes_right_is_used(player):
    """An autopilot before its receiver set its time."""
    flight = player().play(3.0, off={"fix": -DAY, "gimbal": -DAY})
    assert not any(r.estimates for r in flight.results)
    flight.play(4.0).end()
    assert flight.names(4.0) == [NAMES] * 3 * RATE
    assert len(flight.reported("was set")) == 2
    assert flight.engine.happened == Counter()


def test_images_whose_clock_comes_right_are_used(player):
    flight = player().play(4.0, off={"detections": -DAY}).play(4.0).end()
    late = flight[-3 * RATE :]
    assert [[e.robot_id for e in r.estimates] for r in late] == [NAMES] * 3 * RATE


def test_a_clock_that_stays_elsewhere_is_reported_as_such(flown):
    flight = flown(5.0).play(15.0, off={"detections": DAY}).end()
    assert {one.reason for r in flight[-2 * RATE :] for one in r.rejections} == {Reason.STALE_FIX}


@pytest.mark.parametrize("name", NEEDED)
def test_an_input_may_be_silent(flown, name):
    flight = flown(4.0).play(20.0, without=(name,)).play(4.0)
    results = flight.end()
    assert {e.robot_id for r in results[-RATE:] for e in r.estimates} == set(NAMES)
    assert flight.engine.inputs[name].bad == 0
    assert flight.reported("refused: stamped") == []


def test_all_may_be_silent_and_messages_may_come_in_a_burst(sea):
    """The time between is unknown: a recording with a gap."""
    engine, world = sea.estimator(), sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    sea.play(engine, world, 3.0, until_flush=False)
    results = sea.play(engine, world, 3.0, begin=40.0)
    assert all(not r.rejections for r in results)
    assert engine.happened == Counter()
    assert engine.inputs["fix"].bad == 0


def test_a_camera_on_a_mast_needs_several_images(sea):
    values = {"fix.source": "constant", "fix.latitude_deg": 13.194, "fix.longitude_deg": -59.6415}
    values |= {"gimbal.source": "constant", "height.source": "constant", "height.value_m": 30.0}
    engine = sea.estimator(values)
    engine.add_camera(sea.stamp(0.0), sea.camera)
    for i in range(30):
        engine.add_detections(sea.boxes(0.1 * i, [sea.middle]))
        engine.advance(sea.stamp(0.1 * i))
    engine.add_detections(sea.boxes(DAY, [sea.middle]))
    for i in range(30, 40):
        engine.add_detections(sea.boxes(0.1 * i, [sea.middle]))
        engine.advance(sea.stamp(0.1 * i))
    assert engine.happened == Counter()
    for i in range(10):
        engine.add_detections(sea.boxes(-50.0 + 0.1 * i, [sea.middle]))
        engine.advance(sea.stamp(4.0 + 0.1 * i))
    assert engine.happened == {"time_went_backward": 1}
    assert math.isclose(engine.robots[0].last_seen_ns, sea.stamp(-49.1), abs_tol=2.0)


def test_what_waits_is_bounded(flown):
    flight = flown(2.0)
    for i in range(6000):
        flight.send("fix", 0.001 * i, DAY)
    assert len(flight.engine._intake.arrivals._held) <= 4096


def swimming(flight):
    """Robots at 1 m/s: two of them 2 m from one another, one behind the other."""
    starts = {"a": (-6.0, 20.0), "b": (-8.0, 20.0), "c": (8.0, 30.0)}
    flight.world.robots = {name: lambda t, at=at: (at[0] + t, at[1]) for name, at in starts.items()}
    return flight


def whose(flight, since):
    """By name, the robot that it is on in every image from a stamp on."""
    found = {}
    for result, t in since:
        for one in result.estimates:
            if one.state is State.CONFIRMED:
                apart = {
                    name: np.hypot(*np.subtract(at(t), one.position))
                    for name, at in flight.world.robots.items()
                }
                found.setdefault(one.robot_id, set()).add(min(apart, key=apart.get))
    return found


def seconds(sea, result):
    return (result.stamp_ns - sea.stamp(0.0)) * 1e-9


@pytest.mark.parametrize("by", [DAY, -DAY, 4.0, -4.0])
@pytest.mark.parametrize("node", [True, False])
def test_all_clocks_step_and_names_stay(player, sea, by, node):
    """The node's clock goes along, and a steady one shows the time; or it does not."""
    flight = swimming(player()).play(4.0, steady=70.0)
    before = len(flight.results)
    clock = by if node else 0.0
    flight.play(4.0, off=dict.fromkeys(ALL, by), clock=clock, steady=70.0).end()
    after = [(r, seconds(sea, r) - by) for r in flight.results[before:]]
    after = [(r, t) for r, t in after if 4.3 < t < 9.0]
    assert len(after) > 3 * RATE
    known = whose(flight, [(r, seconds(sea, r)) for r in flight.results[5:before]])
    assert [len(robots) for robots in known.values()] == [1, 1, 1]
    assert whose(flight, after) == known
    assert len(flight.reported("keep their labels")) == 1
    last = [(one.last_seen_ns, r.stamp_ns) for r, _ in after for one in r.estimates]
    assert all(seen_ns == stamp_ns for seen_ns, stamp_ns in last)


def test_a_node_s_clock_that_steps_along_tells_nothing(flown):
    """Nobody knows how long it took."""
    flight = flown(4.0).play(4.0, off=dict.fromkeys(ALL, -DAY), clock=-DAY)
    names = {e.robot_id for e in flight.end()[-1].estimates}
    assert names.isdisjoint(NAMES)


def test_another_scene_has_new_names(flown):
    """A recording that begins again, while the node's clock goes on."""
    flight = flown(6.0)
    flight.world.robots = {
        name: lambda _t, at=at: at
        for name, at in {"a": (8.0, 24.0), "b": (-3.0, 31.0), "c": (-8.0, 19.0)}.items()
    }
    flight.play(6.0, off=dict.fromkeys(ALL, -DAY)).end()
    assert {e.robot_id for e in flight.results[-1].estimates}.isdisjoint(NAMES)
    assert len(flight.reported("it is another scene")) == 1
    assert len(flight.results[-1].estimates) == 3


def test_images_alone_lack_telemetry_of_their_time(flown):
    """Their arrival does not show it well enough."""
    flight = flown(5.0).play(15.0, off={"detections": DAY}, steady=0.0)
    flight.end()
    assert {one.reason for r in flight.results[-2 * RATE :] for one in r.rejections} == {
        Reason.STALE_FIX
    }


def test_names_are_saved_as_they_are_stamped(player, tmp_path):
    path = tmp_path / "names.json"
    flight = player({"state_file": str(path)}).play(4.0)
    flight.play(4.0, off=dict.fromkeys(ALL, DAY)).end()
    seen = {one.last_seen_ns for one in load(path).robots}
    assert seen == {flight.results[-1].stamp_ns}


def test_predictions_are_stamped_like_images(flown):
    flight = flown(4.0).play(4.0, off=dict.fromkeys(ALL, DAY))
    last = flight.results[-1].stamp_ns
    ahead = flight.engine.predicted(last + 2_000_000_000)
    assert ahead.stamp_ns == last + 2_000_000_000
    assert [one.last_seen_ns for one in ahead.estimates] == [last] * 3
    assert flight.engine.predicted(last) is None
