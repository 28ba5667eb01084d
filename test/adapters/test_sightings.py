# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Positions as Cursor on Target and MAVLink want them."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.adapters.sightings import (
    Sighting,
    cursor_on_target,
    host_and_port,
    sighting,
    tracking_geo_status,
)
from aerial_gnss_ros.core.values.errors import InputError

SEEN = Sighting(
    "aqua_1", 1_735_689_600_123_456_789, math.radians(13.19393871), math.radians(-59.64150657),
    math.nan, 1.25, measured=True,
)  # fmt: skip


def test_an_event_has_place_time_and_error():
    event = ET.fromstring(cursor_on_target(SEEN, stale_s=10.0))  # noqa: S314 - our own
    assert event.tag == "event"
    assert event.attrib == {
        "version": "2.0", "uid": "aerial_gnss_ros.aqua_1", "type": "a-f-S", "how": "m-f",
        "time": "2025-01-01T00:00:00.123Z", "start": "2025-01-01T00:00:00.123Z",
        "stale": "2025-01-01T00:00:10.123Z",
    }  # fmt: skip
    assert event.find("point").attrib == {
        "lat": "13.19393871", "lon": "-59.64150657", "hae": "9999999.00", "ce": "1.25",
        "le": "9999999.0",
    }  # fmt: skip
    assert event.find("detail/contact").get("callsign") == "aqua_1"
    known = replace(SEEN, altitude=-40.5, robot_id='a"<&', measured=False)
    event = ET.fromstring(cursor_on_target(known, "a-f-U"))  # noqa: S314 - our own
    assert (event.get("type"), event.find("point").get("hae")) == ("a-f-U", "-40.50")
    assert event.find("detail/contact").get("callsign") == 'a"<&'
    assert "predicted" in event.find("detail/remarks").text


def test_robots_of_two_drones_are_two_marks():
    drones = [replace(SEEN, namespace=name) for name in ("", "drone1", "drone2")]
    events = [ET.fromstring(cursor_on_target(seen)) for seen in drones]  # noqa: S314 - our own
    assert [event.get("uid") for event in events] == [
        "aerial_gnss_ros.aqua_1",
        "aerial_gnss_ros.drone1.aqua_1",
        "aerial_gnss_ros.drone2.aqua_1",
    ]
    assert events[2].find("detail/contact").get("callsign") == "drone2/aqua_1"


def test_mavlink_wants_sea_level_and_nan_for_what_is_unknown():
    fields = tracking_geo_status(SEEN)
    assert (fields["lat"], fields["lon"], fields["tracking_status"]) == (131939387, -596415066, 1)
    assert math.isnan(fields["alt"])
    assert math.isnan(fields["vel_n"])
    # EGM96 puts sea level 48.0 m below the ellipsoid there.
    assert tracking_geo_status(replace(SEEN, altitude=-43.0))["alt"] == pytest.approx(5.0, abs=0.1)
    assert tracking_geo_status(replace(SEEN, measured=False))["tracking_status"] == 0


def test_mavlink_bytes_are_read_back_by_pymavlink(monkeypatch):
    monkeypatch.setenv("MAVLINK20", "1")
    dialect = pytest.importorskip(
        "pymavlink.dialects.v20.common", reason="pymavlink (extra [mavlink]) is not installed"
    )
    sent = []
    writer = SimpleNamespace(write=sent.append)
    mavlink = dialect.MAVLink(writer, srcSystem=7, srcComponent=100)
    mavlink.camera_tracking_geo_status_send(**tracking_geo_status(SEEN))
    [message] = dialect.MAVLink(None).parse_buffer(sent[0])
    assert message.get_msgId() == 276
    assert (message.lat, message.lon) == (131939387, -596415066)
    assert message.h_acc == 1.25
    assert message.get_srcSystem() == 7


def test_a_published_fix_becomes_a_sighting():
    stamp = SimpleNamespace(sec=5, nanosec=7)
    message = SimpleNamespace(
        header=SimpleNamespace(stamp=stamp), latitude=10.0, longitude=20.0, altitude=3.0,
        position_covariance=[4.0, 0, 0, 0, 2.0, 0, 0, 0, 9.0],
        status=SimpleNamespace(status=-1),
    )  # fmt: skip
    seen = sighting("aqua_1", message, "/drone1/")
    assert seen.namespace == "drone1"
    assert (seen.stamp_ns, seen.altitude, seen.measured) == (5_000_000_007, 3.0, False)
    assert seen.latitude == pytest.approx(math.radians(10.0))
    assert seen.sigma == pytest.approx(math.sqrt(3.0))


@pytest.mark.parametrize(
    ("text", "pair"),
    [("127.0.0.1:4242", ("127.0.0.1", 4242)), ("[::1]:9", ("::1", 9)), ("tak:1", ("tak", 1))],
)  # fmt: skip
def test_addresses(text, pair):
    assert host_and_port(text) == pair


@pytest.mark.parametrize("text", ["", "host", "host:", ":5", "host:0", "host:70000", "host:x"])
def test_what_is_no_address_is_refused(text):
    with pytest.raises(InputError, match="is not HOST:PORT"):
        host_and_port(text)


def test_no_text_makes_the_event_unreadable():
    hostile = replace(SEEN, robot_id="a\x00\x1b\ud800\uffff", namespace="<&'\"\n>", sigma=math.nan)
    event = ET.fromstring(cursor_on_target(hostile))  # noqa: S314 - our own
    assert event.find("detail/contact").get("callsign") == "<&'\"\ufffd>/a\ufffd\ufffd\ufffd\ufffd"
    assert event.find("point").get("ce") == "9999999.00"


@pytest.mark.parametrize(
    ("latitude", "longitude"), [(math.nan, 0.0), (0.0, math.inf), (91.0, 0.0), (0.0, -180.1)]
)
def test_a_published_fix_that_is_no_position_is_refused(latitude, longitude):
    message = SimpleNamespace(
        header=SimpleNamespace(stamp=SimpleNamespace(sec=1, nanosec=0)),
        latitude=latitude, longitude=longitude, altitude=math.nan,
        position_covariance=[1.0] * 9, status=SimpleNamespace(status=0),
    )  # fmt: skip
    with pytest.raises(InputError, match=r"the position of a_1, .*, is invalid"):
        sighting("a_1", message)
