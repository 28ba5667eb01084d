# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the origin of `map` lies, and where it cannot."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.values.events import ErrorText, Events
from aerial_gnss_ros.core.values.samples import Fix

LATITUDE, LONGITUDE = 13.194, -59.6415


def fix(north_km=0.0):
    return Fix(1, math.radians(LATITUDE + north_km / 111.195), math.radians(LONGITUDE), 5.0)


def origin(**given):
    return MapOrigin(estimator_config({f"map.{k}": v for k, v in given.items()}), None, Events())


def test_the_origin_is_settled_once_fixes_agree():
    one = origin()
    assert one.accept(fix(), 0.0, robots=False) == ""
    assert one.local is not None
    one.accept(fix(0.1), 2.9, robots=False)
    assert one.datum is None
    one.accept(fix(0.2), 3.0, robots=False)
    assert one.datum.latitude == fix().latitude


def test_what_is_published_settles_it_at_once():
    one = origin()
    one.settle()
    assert one.datum is None
    one.accept(fix(), 0.0, robots=False)
    one.settle()
    assert one.datum.latitude == fix().latitude


@pytest.mark.parametrize("agreed_s", [0.0, 5.0])
def test_it_follows_the_drone_while_no_robot_is_known(agreed_s):
    one = origin()
    one.accept(fix(), agreed_s, robots=False)
    assert one.accept(fix(19.0), agreed_s, robots=False) == ""
    assert one.local.datum.latitude == fix().latitude
    assert "21 km from the origin of map" in one.accept(fix(21.0), agreed_s, robots=True)
    assert one.accept(fix(21.0), agreed_s, robots=False) == ""
    assert one.local.datum.latitude == fix(21.0).latitude
    assert (one.datum is None) == (agreed_s < 3.0)
    assert one.trouble == ""


def test_places_near_the_origin_only():
    one = origin()
    one.accept(fix(), 0.0, robots=False)
    assert one.covers(fix(19.0).latitude, fix().longitude)
    assert not one.covers(fix(21.0).latitude, fix().longitude)


def test_a_configured_origin_too_far_away_is_refused_in_a_sentence():
    log = Events()
    config = estimator_config({"map.latitude_deg": LATITUDE + 1.0, "map.longitude_deg": LONGITUDE})
    one = MapOrigin(config, None, log)
    assert "111 km from the origin" in one.accept(fix(), 2.9, robots=False)
    assert one.trouble == ""  # one fix may be wrong
    one.accept(fix(), 3.0, robots=False)
    one.accept(fix(), 3.1, robots=False)
    assert one.trouble.startswith("The origin of map (14.194, -59.6415) is 111 km from the drone")
    assert [str(reported) for reported in log.sentences if isinstance(reported, ErrorText)] == [
        one.trouble
    ]
    assert one.datum.latitude == math.radians(LATITUDE + 1.0)


def test_at_the_end_of_a_short_recording_it_is_refused_too():
    one = origin(latitude_deg=LATITUDE + 1.0, longitude_deg=LONGITUDE)
    one.accept(fix(), 0.5, robots=False)
    one.settle()
    assert "correct map.latitude_deg and map.longitude_deg" in one.trouble


def test_a_configured_origin_near_the_flight_stays():
    one = origin(latitude_deg=LATITUDE + 0.1, longitude_deg=LONGITUDE)
    assert one.accept(fix(), 3.0, robots=False) == ""
    one.settle()
    assert one.trouble == ""
    assert one.datum.latitude == math.radians(LATITUDE + 0.1)
