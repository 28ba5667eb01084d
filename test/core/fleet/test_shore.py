# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What drones send is joined, in any order; what cannot be is refused, and the others go on."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.outbox import Outbox
from aerial_gnss_ros.core.fleet.shore import TUNING, Shore
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import MapDatum

SECOND_NS = 10**9


class Clock:
    """A clock that goes on by a second each time that it is read."""

    def __init__(self):
        self.ns = 0

    def __call__(self):
        self.ns += SECOND_NS
        return self.ns


@pytest.fixture(scope="module")
def flown(fleet_of):
    """Two drones with every second image as sent, and the first one's origin."""
    made = fleet_of(duration=5.0, images=10.0, seed=8)
    boxes = {name: Outbox(name) for name in made.sightings}
    sent = {name: [boxes[name].add(s) for s in of[::2]] for name, of in made.sightings.items()}
    origin = made.made["a"].flight.origin
    return made, sent, origin


@pytest.fixture
def shore(flown):
    """Return a shore that knows both drones."""
    made, _, origin = flown
    shore = Shore(["north/a", "b"], 0.5, None, Clock())
    shore.describe("b", "b", made.configs["b"], None)
    assert shore.history is None
    shore.describe("north/a", "a", made.configs["a"], origin)
    return shore


def scene_ns(sent):
    return sent.sighting.pose.stamp_ns


def give(shore, sent, delay_ns=0):
    shore.add({"a": "north/a", "b": "b"}[sent.drone], sent, scene_ns(sent) + delay_ns)


def test_both_drones_are_joined_though_one_is_late(shore, flown):
    made, sent, _ = flown
    for one in sent["a"]:
        give(shore, one, SECOND_NS // 10)
    result = shore.advance()
    assert result.stamp_ns == sent["a"][-1].sighting.stamp_ns
    for one in reversed(sent["b"]):
        give(shore, one, 2 * SECOND_NS)
    assert shore.links["b"].gaps.missing == 0
    result = shore.advance()
    fleet = Fleet(made.configs, made.local)
    for one in sorted([*sent["a"], *sent["b"]], key=lambda s: (scene_ns(s), s.drone)):
        update = fleet.update(one.drone, one.sighting)
    assert [e.robot_id for e in result.estimates] == [e.robot_id for e in update.estimates]
    for one, other in zip(result.estimates, update.estimates, strict=True):
        assert (one.latitude, one.longitude) == (other.latitude, other.longitude)
    assert shore.links["north/a"].delay_s == pytest.approx(0.1)
    assert shore.links["b"].delay_s == pytest.approx(2.0)
    for link in shore.links.values():
        assert link.seen is sent[link.drone][-1].sighting
    assert shore.links["b"].update.report.drone == "b"
    assert shore.links["b"].gaps.repeated == 0
    assert shore.advance() is None


def test_a_drone_that_joins_in_flight_begins_anew_with_what_is_kept(flown):
    made, sent, origin = flown
    shore = Shore(["north/a", "b"], 0.5, origin, Clock())
    shore.describe("north/a", "a", made.configs["a"], MapDatum(0.0, 0.0, 0.0))
    assert shore.datum is origin  # given by parameters
    half = len(sent["a"]) // 2
    for one in sent["a"]:
        give(shore, one)
    for one in sent["b"][:half]:  # waits for the parameters
        give(shore, one)
    shore.advance()
    shore.describe("b", "b", made.configs["b"], None)
    for one in sent["b"][half:]:
        give(shore, one)
    result = shore.advance()
    fleet = Fleet(made.configs, made.local)
    for one in sorted([*sent["a"], *sent["b"]], key=lambda s: (scene_ns(s), s.drone)):
        update = fleet.update(one.drone, one.sighting)
    assert repr(result.estimates) == repr(update.estimates)


def test_a_changed_parameter_counts_from_now_on_only_if_the_fleet_uses_it(shore):
    history, fleet = shore.history, shore.history.fleet
    swim = {"tracks.find_moored": False}
    same = estimator_config({"noise.set": "consumer", "fix.altitude_datum": "amsl"} | swim)
    shore.describe("b", "b", same, None)
    assert shore.history.fleet is fleet
    shore.describe("b", "b", estimator_config({"noise.set": "consumer"}), None)
    assert shore.history.fleet is not fleet
    fleet = shore.history.fleet
    shore.describe("b", "b", estimator_config({"noise.set": "rtk"}), None)
    assert shore.history is history
    assert shore.history.fleet is not fleet
    fleet = shore.history.fleet
    pier = {"pier": {"class": "beacon", "position": [13.0, -59.0], "sigma_m": 0.05}}
    shore.describe("b", "b", estimator_config({"noise.set": "rtk", "references": pier}), None)
    assert shore.history.fleet is not fleet


def test_positions_go_on_without_images_and_names_through_new_parameters(shore, flown):
    _, sent, _ = flown
    assert shore.predicted(0).estimates == ()
    for one in [*sent["a"], *sent["b"]]:
        give(shore, one)
    last = shore.advance()
    stamp_ns = last.stamp_ns + 3 * SECOND_NS
    later = shore.predicted(stamp_ns)
    assert (later.stamp_ns, later.datum) == (stamp_ns, last.datum)
    assert [one.robot_id for one in later.estimates] == [one.robot_id for one in last.estimates]
    for one, before in zip(later.estimates, last.estimates, strict=True):
        assert one.sigma > before.sigma
    for robot in shore.history.fleet.table.robots:
        robot.name = robot.name.replace("aqua", "robot")
    shore.describe("b", "b", estimator_config({"noise.set": "rtk"}), None)
    anew = shore.advance()
    assert {one.robot_id for one in anew.estimates} == {f"robot_{k}" for k in (1, 2, 3)}
    assert Shore(["b"], 0.5, None, Clock()).predicted(0) is None


def refused(shore, sent, delay_ns=0):
    with pytest.raises(InputError) as error:
        give(shore, sent, delay_ns)
    return str(error.value)


def test_what_cannot_be_joined_is_refused_and_the_others_go_on(shore, flown):
    made, sent, _ = flown
    with pytest.raises(InputError, match="b and north/a both call themselves drone a"):
        shore.describe("b", "a", made.configs["b"], None)
    with pytest.raises(InputError, match="latency_s must be 0"):
        shore.describe("b", "b", estimator_config({"noise.latency_s": 0.1}), None)
    with pytest.raises(InputError, match="is drone b, but sends images of c"):
        shore.add("b", replace(sent["b"][0], drone="c"), scene_ns(sent["b"][0]))
    bad = sent["b"]
    assert "3600 s ahead" in refused(shore, bad[0], -3600 * SECOND_NS)
    give(shore, bad[1], -round(TUNING.ahead_s * SECOND_NS))
    pose = replace(bad[2].sighting.pose, latitude=bad[2].sighting.pose.latitude + math.radians(3))
    far = replace(bad[2], sighting=replace(bad[2].sighting, pose=pose))
    assert re.search(r"33\d km from the origin of map", refused(shore, far))
    old = replace(bad[3].sighting.pose, stamp_ns=scene_ns(bad[3]) - 70 * SECOND_NS)
    late = replace(bad[3], sighting=replace(bad[3].sighting, pose=old))
    assert "older than the 65 s" in refused(shore, late, 70 * SECOND_NS)
    give(shore, bad[1])
    assert shore.links["b"].refused == {
        "clock_ahead": 1, "other_site": 1, "too_late": 1
    }  # fmt: skip
    assert shore.links["b"].gaps.repeated == 1
    for one in sent["a"]:
        give(shore, one)
    assert shore.advance().estimates
    assert not shore.links["north/a"].refused


def test_a_clock_an_hour_behind_is_refused_and_the_others_go_on(shore, flown):
    """Its images are older than what is kept, once another drone has sent its own."""
    made, sent, _ = flown

    def behind(one):
        pose = replace(one.sighting.pose, stamp_ns=scene_ns(one) - 3600 * SECOND_NS)
        return replace(one, sighting=replace(one.sighting, pose=pose))

    first, *rest = sent["b"]
    shore.add("b", behind(first), scene_ns(first))  # nothing else is known yet
    for one in sent["a"]:
        give(shore, one)
    for one in rest:
        with pytest.raises(InputError, match="3600 s old by this computer's clock: the drone's c"):
            shore.add("b", behind(one), scene_ns(one))
    result = shore.advance()
    assert shore.links["b"].refused == {"too_late": len(rest)}
    assert not shore.links["north/a"].refused
    fleet = Fleet(made.configs, made.local)
    for one in sent["a"]:
        update = fleet.update("a", one.sighting)
    assert repr(result.estimates) == repr(update.estimates)


def test_what_becomes_of_references_is_said_once_though_the_fleet_goes_back(shore, flown):
    _, sent, _ = flown
    for one in [*sent["a"], *sent["b"]]:
        give(shore, one)
    shore.advance()
    update = shore.links["b"].update
    for words in ("pier is a_1: one", "pier is a_1: again", "pier is not used: two"):
        shore._note(replace(update, notes=(words,)))
    assert shore.notes == ["pier is a_1: one", "pier is not used: two"]


def test_a_sender_that_floods_is_held_to_a_rate(shore, flown):
    one = flown[1]["b"][0]
    for number in range(TUNING.most_hz):
        shore.add("b", replace(one, sequence=number), scene_ns(one))
    sentence = refused(shore, replace(one, sequence=999))
    assert "more than 100 images a second" in sentence
    for second in range(1, 200):
        pose = replace(one.sighting.pose, stamp_ns=scene_ns(one) + second * SECOND_NS)
        later = replace(one, sequence=999 + second, sighting=replace(one.sighting, pose=pose))
        shore.add("b", later, scene_ns(later))
    assert len(shore.links["b"].rates) < 70


def test_a_flood_of_messages_is_not_even_read_and_ends_with_its_second(flown):
    now, shore = [5 * SECOND_NS], Shore(["a", "b"], 0.5, None, lambda: now[0])
    shore.describe("b", "b", flown[0].configs["b"], None)
    for _ in range(TUNING.most_read_hz):
        shore.admit("b")
    with pytest.raises(InputError, match="more than 300 messages a second"):
        shore.admit("b")
    assert shore.links["b"].refused == {"flood": 1}
    shore.admit("a")
    now[0] += SECOND_NS
    shore.admit("b")


def test_a_clock_that_goes_backward_begins_anew(shore, flown):
    sent = flown[1]
    first_ns = scene_ns(sent["a"][0])
    assert not shore.follow_clock(first_ns + 100 * SECOND_NS)
    for one in sent["a"]:
        pose = replace(one.sighting.pose, stamp_ns=scene_ns(one) + 100 * SECOND_NS)
        give(shore, replace(one, session=7, sighting=replace(one.sighting, pose=pose)))
    shore.advance()
    assert not shore.follow_clock(first_ns + (100 - round(TUNING.ahead_s)) * SECOND_NS)
    assert shore.follow_clock(first_ns)
    for name in "ab":
        for one in sent[name]:
            give(shore, replace(one, session=1))
    result = shore.advance()
    assert result.stamp_ns == sent["a"][-1].sighting.stamp_ns
    assert not shore.links["b"].refused
    assert len(result.estimates) == 3


def test_a_restart_is_said_once(shore, flown):
    first, second, *rest = flown[1]["a"][:6]
    for one in (first, second):
        give(shore, one)
    assert shore.notes == []
    for one in rest:
        give(shore, replace(one, session=first.session + 1))
    give(shore, replace(rest[0], session=first.session))  # still on its way: refused, and not news
    (note,) = shore.notes
    assert note.startswith("Drone a has restarted")


def test_a_drone_that_changes_its_name_is_another_one(shore, flown):
    made, sent, _ = flown
    for one in [*sent["a"], *sent["b"]]:
        give(shore, one)
    shore.advance()
    shore.describe("b", "c", made.configs["b"], None)
    for one in sent["b"]:
        shore.add("b", replace(one, drone="c"), scene_ns(one))
    result = shore.advance()
    assert not shore.history.refused
    assert len(result.estimates) == 3
    assert shore.links["b"].update.report.drone == "c"
