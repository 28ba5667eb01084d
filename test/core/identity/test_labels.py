# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Old names, bound names, numbers: in this order, each once."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.labels import ConfirmedTrack, Labels
from aerial_gnss_ros.core.identity.saved_labels import SavedNames, SavedRobot
from aerial_gnss_ros.core.values.estimates import MapDatum, RobotEstimate, State
from aerial_gnss_ros.core.values.events import Events

LOCAL = LocalMap(MapDatum(math.radians(13.194), math.radians(-59.6415), math.nan))
SECOND = 1_000_000_000


def _place_deg(east, north):
    latitude, longitude = LOCAL.places(np.array([[east, north]]))
    return [math.degrees(latitude[0]), math.degrees(longitude[0])]


def _identity(bindings=(), saved=(), log=None):
    robots = {
        name: {"class": class_id, "start": _place_deg(*start)} for name, class_id, start in bindings
    }
    entries = []
    for name, (east, north), seen_s in saved:
        latitude, longitude = LOCAL.places(np.array([[east, north]]))
        seen_ns = seen_s * SECOND
        entries.append(
            SavedRobot(name, "aqua", float(latitude[0]), float(longitude[0]), seen_ns, 1.5)
        )
    return Labels(
        estimator_config({"robots": robots}),
        SavedNames(tuple(entries), {"aqua": len(entries)}),
        log,
    )


def _seen(east, north, class_id="aqua", t=100):
    return ConfirmedTrack(class_id, t * SECOND, np.array([east, north]), np.eye(2) * 2.0)


def test_another_tracker_of_the_same_boxes_gives_the_same_labels():
    first = _identity(saved=[("aqua_1", (0.0, 0.0), 90)])
    assert first.assign([_seen(0.0, 0.0), _seen(50.0, 0.0)], LOCAL) == ["aqua_1", "aqua_2"]
    other = first.beside()
    other.tell({(1, 5.0, 5.0): "aqua_2", (2, 6.0, 6.0): "aqua_2", (2, 9.0, 9.0): "aqua_1"})
    one = replace(_seen(80.0, 9.0), boxes=((1, 5.0, 5.0), (2, 6.0, 6.0), (2, 9.0, 9.0)))
    again = replace(_seen(90.0, 9.0), boxes=((2, 6.0, 6.0),))
    assert other.assign([_seen(70.0, 0.0), one], LOCAL) == ["aqua_3", "aqua_2"]
    assert other.assign([again], LOCAL) == ["aqua_4"]  # each label once
    third = other.beside()
    third.tell({(2, 6.0, 6.0): "aqua_2"})
    assert third.assign([again], LOCAL) == ["aqua_2"]  # once for each tracker
    assert first.assign([_seen(99.0, 0.0)], LOCAL) == ["aqua_5"]  # and each number
    assert {one.name for one in first.saved().robots} == {one.name for one in other.saved().robots}


STARTS = (("leader", "aqua", (0.0, 0.0)), ("second", "Aqua", (12.0, 0.0)))


@pytest.mark.parametrize(
    ("shared", "classes", "names"),
    [
        # Most boxes decide, each label once.
        ({"31": 5, "32": 1, "12": 4}, "13", {"3": "1", "1": "2"}),
        # Whose label is another's then gets a number: 4 is the next one.
        ({"21": 3}, "12", {"2": "1", "1": "4"}),
        ({"11": 3, "22": 3}, "12", {}),
        ({"11": 1, "12": 3, "21": 3, "22": 9}, "12", {}),
        ({}, "12", {}),
    ],
)
def test_robots_are_called_as_another_tracker_has_called_most_of_their_boxes(
    shared, classes, names
):
    identity = _identity()
    identity.assign([_seen(0.0, 0.0), _seen(9.0, 0.0), _seen(99.0, 0.0)], LOCAL)
    found = identity.beside().adopted(
        {(f"aqua_{a}", f"aqua_{b}"): count for (a, b), count in shared.items()},
        {f"aqua_{one}": "aqua" for one in classes},
    )
    assert found == {f"aqua_{one}": f"aqua_{other}" for one, other in names.items()}


@pytest.mark.parametrize(
    ("sightings", "names"),
    [
        ([_seen(1, 0)], ["leader"]),
        ([_seen(11, 0), _seen(2, 1)], ["second", "leader"]),
        # both nearer to leader's start: together the nearest pairs win
        ([_seen(5, 0), _seen(0, 0)], ["second", "leader"]),
        ([_seen(0, 0, "buoy")], ["buoy_1"]),  # of another class
        ([_seen(0, 11), _seen(40, 0)], ["aqua_1", "aqua_2"]),  # nobody within 10 m
    ],
)
def test_names_bound_to_starts(sightings, names):
    assert _identity(STARTS).assign(sightings, LOCAL) == names


def test_a_bound_name_goes_to_the_first_and_to_no_other():
    identity = _identity(STARTS)
    assert identity.assign([_seen(0, 0)], LOCAL) == ["leader"]
    assert identity.assign([_seen(0, 0)], LOCAL) == ["aqua_1"]
    identity.release()
    assert identity.assign([_seen(0, 0), _seen(0, 40)], LOCAL) == ["leader", "aqua_2"]


@pytest.mark.parametrize(
    ("sighting", "words"),
    [
        (_seen(0, 26), ["A robot 26 m from the start of leader is labelled aqua_1", "allows 10 m"]),
        (_seen(11, 0, "buoy"), ["1 m from the start of second", "'buoy'", "'Aqua' is expected"]),
    ],
)
def test_a_start_that_nobody_came_near_is_reported_once(sighting, words):
    log = Events()
    identity = _identity(STARTS, log=log)
    identity.assign([sighting], LOCAL)
    identity.assign([sighting], LOCAL)
    (reported,) = log.drain()
    assert all(word in reported for word in words)


@pytest.mark.parametrize("starts", [(), STARTS[:1]])
def test_nothing_is_reported_of_starts_that_have_their_robots(starts):
    log = Events()
    identity = _identity(starts, log=log)
    identity.assign([_seen(0, 0)], LOCAL)
    identity.assign([_seen(40, 0)], LOCAL)
    assert log.drain() == []


OLD = (("aqua_1", (0.0, 0.0), 0), ("aqua_2", (60.0, 0.0), 0))


@pytest.mark.parametrize(
    ("sightings", "names"),
    [
        ([_seen(58, 3), _seen(2, -4)], ["aqua_2", "aqua_1"]),
        ([_seen(2, -4, "buoy")], ["buoy_1"]),
        ([_seen(900, 0)], ["aqua_3"]),  # 100 s at 1.5 m/s do not lead so far
        ([_seen(2, 0), _seen(3, 0), _seen(59, 0)], ["aqua_1", "aqua_3", "aqua_2"]),
        ([_seen(2, 0, t=8000)], ["aqua_3"]),  # more than an hour later
    ],
)
def test_names_taken_up_after_a_restart(sightings, names):
    assert _identity(saved=OLD).assign(sightings, LOCAL) == names


def test_an_old_name_goes_before_a_start_and_the_file_keeps_what_was_not_seen():
    identity = _identity(STARTS, saved=(("leader", (30.0, 0.0), 0), ("aqua_7", (900.0, 0.0), 0)))
    assert identity.assign([_seen(29, 0), _seen(1, 0)], LOCAL) == ["leader", "aqua_3"]
    kept = {robot.name for robot in identity.saved().robots}
    assert kept == {"leader", "aqua_7"}
    assert identity.saved().numbers == {"aqua": 3}


def _estimate(name, east, north, seen_s):
    latitude, longitude = LOCAL.places(np.array([[east, north]]))
    return RobotEstimate(
        seen_s * SECOND, name, "aqua", State.CONFIRMED, float(latitude[0]), float(longitude[0]),
        math.nan, np.array([east, north]), np.zeros(2), np.eye(4), seen_s * SECOND,
    )  # fmt: skip


def test_robots_whose_tracks_are_lost_are_found_again_by_their_places():
    identity = _identity(bindings=[("leader", "aqua", (0.0, 0.0))])
    places = [(0.0, 0.0), (50.0, 0.0), (0.0, 60.0)]
    first = identity.assign([_seen(*place, t=1) for place in places], LOCAL)
    assert first == ["leader", "aqua_1", "aqua_2"]
    moved = [(30.0, 30.0), (52.0, 0.0), (0.0, 59.0)]
    identity.expect(
        _estimate(name, *place, 10) for name, place in zip(first[:2], moved[:2], strict=True)
    )
    again = [_seen(*place, t=12) for place in (*reversed(moved), (90.0, 90.0))]
    assert identity.assign(again, LOCAL) == ["aqua_3", "aqua_1", "leader", "aqua_4"]


def test_a_bound_robot_that_is_not_where_it_was_may_be_at_its_start():
    identity = _identity(bindings=[("leader", "aqua", (0.0, 0.0))])
    assert identity.assign([_seen(0, 0, t=1)], LOCAL) == ["leader"]
    identity.expect([_estimate("leader", 400.0, 0.0, 10)])
    assert identity.assign([_seen(1, 0, t=12)], LOCAL) == ["leader"]
    assert identity.assign([_seen(400, 0, t=13)], LOCAL) == ["aqua_1"]
