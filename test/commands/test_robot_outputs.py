# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""GPS_INPUT, NMEA 0183 and AIS, as parsers of others read what was sent by UDP."""

from __future__ import annotations

import math
import select
import socket
from dataclasses import replace

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.commands.robot_outputs import (
    Ais,
    Fresh,
    ToRobots,
    gps_input_encoder,
    nmea_datagram,
    target_absolute_encoder,
)
from aerial_gnss_ros.core.geometry.geoid import undulation

STAMP = 1_700_000_000_120_000_000  # 2023-11-14 22:13:20.12 UTC, a Tuesday
SEEN = Sighting(
    "aqua_1", STAMP, math.radians(13.19394), math.radians(-59.64151), math.nan, 1.0, True, "d1"
)
WEST_OF_GREENWICH = replace(SEEN, latitude=math.radians(-0.999_999_99999), longitude=-1e-9)


@pytest.fixture
def plotter():
    """Return a UDP socket that waits, and its address."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        yield receiver, receiver.getsockname()


def later(seen, seconds, **changes):
    return replace(seen, stamp_ns=seen.stamp_ns + round(seconds * 1e9), **changes)


def received(receiver):
    found = []
    while select.select([receiver], [], [], 0.3)[0]:
        found.append(receiver.recv(2048))
    return found


def test_the_first_position_may_be_old_and_the_rate_is_kept():
    fresh = Fresh(2.0)
    steps = [fresh.passes(later(SEEN, 0.1 * step)) for step in range(12)]
    assert [step for step, passed in enumerate(steps) if passed] == [1, 6, 11]
    assert not fresh.passes(SEEN)
    assert not fresh.passes(replace(SEEN, robot_id="aqua_2"))


def test_an_autopilot_reads_gps_input(plotter):
    mavlink = pytest.importorskip("pymavlink.dialects.v20.common", reason="pymavlink is absent")
    receiver, address = plotter
    output = ToRobots("GPS_INPUT", {"aqua_1": address}, gps_input_encoder(7, 10), 10.0)
    height = undulation(SEEN.latitude, SEEN.longitude)
    flight = [
        SEEN,  # perhaps latched
        later(SEEN, 1.0, robot_id="aqua_2"),
        later(SEEN, 2.0),
        later(SEEN, 3.0, measured=False),  # coasting
        later(SEEN, 4.0, altitude=height + 1.5),
    ]
    assert [output.send(one) for one in flight] == [False, False, True, False, True]
    output.close()
    first, second = received(receiver)
    parser = mavlink.MAVLink(None)
    one, other = parser.parse_char(first), parser.parse_char(second)
    assert (one.get_type(), one.get_srcSystem()) == ("GPS_INPUT", 7)
    assert (one.lat, one.lon) == (131939400, -596415100)
    assert one.horiz_accuracy == pytest.approx(math.sqrt(2.0))
    assert one.hdop == pytest.approx(math.sqrt(2.0) / 5.0)
    assert (one.fix_type, one.ignore_flags) == (2, 1 | 4 | 8 | 16 | 32 | 128)
    assert (other.fix_type, other.ignore_flags) == (3, 4 | 8 | 16 | 32)
    assert other.alt == pytest.approx(1.5, abs=1e-4)
    assert one.time_usec == STAMP // 1000 + 2_000_000
    # 2023-11-14 is the Tuesday of GPS week 2288; 18 leap seconds.
    assert one.time_week == 2288
    assert one.time_week_ms == ((2 * 24 + 22) * 3600 + 13 * 60 + 22 + 18) * 1000 + 120


def test_a_follower_gets_the_robots_it_is_given_under_their_numbers(plotter):
    receiver, address = plotter
    encode = target_absolute_encoder(7, ["aqua_2", "aqua_1"])
    output = ToRobots("TARGET_ABSOLUTE", {"aqua_2": address, "aqua_1": address}, encode, 10.0)
    flight = [
        SEEN,  # perhaps latched
        later(SEEN, 1.0),
        later(SEEN, 2.0, measured=False),  # coasting
        later(SEEN, 3.0),
        later(SEEN, 0.0, robot_id="aqua_2"),
        later(SEEN, 1.0, robot_id="aqua_2"),
        later(SEEN, 1.0, robot_id="aqua_3"),
    ]
    assert [output.send(one) for one in flight] == [False, True, False, True, False, True, False]
    output.close()
    frames = received(receiver)
    assert [(one[4], one[5], one[-4]) for one in frames] == [(0, 7, 1), (1, 7, 1), (2, 7, 0)]


@pytest.mark.parametrize("seen", [SEEN, replace(SEEN, altitude=-40.0), WEST_OF_GREENWICH])
def test_a_plotter_reads_nmea(plotter, seen):
    pynmea2 = pytest.importorskip("pynmea2", reason="pynmea2 is absent")
    receiver, address = plotter
    output = ToRobots("NMEA", {"aqua_1": address}, nmea_datagram, 10.0)
    assert [output.send(later(seen, step)) for step in (-1.0, 0.0)] == [False, True]
    output.close()
    (data,) = received(receiver)
    gga, rmc = (pynmea2.parse(line, check=True) for line in data.decode().splitlines())
    for sentence in (gga, rmc):
        assert sentence.latitude == pytest.approx(math.degrees(seen.latitude), abs=2e-8)
        assert sentence.longitude == pytest.approx(math.degrees(seen.longitude), abs=2e-8)
        assert sentence.timestamp.isoformat() == "22:13:20.120000+00:00"
    assert (rmc.status, rmc.datestamp.isoformat()) == ("A", "2023-11-14")
    assert (gga.gps_qual, float(gga.horizontal_dil)) == (1, 0.3)
    if math.isnan(seen.altitude):
        assert gga.altitude is None
    else:
        assert gga.altitude + float(gga.geo_sep) == pytest.approx(seen.altitude, abs=0.11)


def test_nmea_says_that_a_robot_is_not_seen():
    pynmea2 = pytest.importorskip("pynmea2", reason="pynmea2 is absent")
    text = nmea_datagram(replace(SEEN, measured=False, sigma=math.inf)).decode()
    gga, rmc = map(pynmea2.parse, text.splitlines())
    assert (gga.gps_qual, gga.horizontal_dil) == (6, "99.9")
    assert (rmc.status, rmc.mode_indicator) == ("V", "E")


def test_a_plotter_shows_robots_that_have_an_mmsi(plotter):
    pyais = pytest.importorskip("pyais", reason="pyais is absent")
    receiver, address = plotter
    output = Ais(address, {"aqua_1": 211234567}, 10.0, clock=lambda: 0.0)
    for seen in (SEEN, later(SEEN, 1.0), later(SEEN, 2.0, measured=False, sigma=9.0)):
        output.send(seen)
        assert not output.send(replace(seen, robot_id="aqua_2"))
    output.close()
    sentences = received(receiver)
    assert all(one.startswith(b"!AIVDM,") for one in sentences)
    position, name, coasting = (pyais.decode(one) for one in sentences)
    assert (position.msg_type, position.mmsi) == (18, 211234567)
    assert position.lat == pytest.approx(13.19394, abs=1e-6)
    assert position.lon == pytest.approx(-59.64151, abs=1e-6)
    assert (position.speed, position.course, position.heading) == (102.3, 360.0, 511)
    assert (position.second, position.accuracy) == (21, True)
    assert (name.msg_type, name.shipname) == (24, "D1/AQUA_1")
    assert (coasting.second, coasting.accuracy) == (62, False)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--nmea", "=127.0.0.1:1"], "give each robot once"),
        (["--nmea", "aqua_1", "--nmea", "aqua_1"], "give each robot once"),
        (["--gps-input", "aqua_1=boat"], "'boat' is not HOST:PORT"),
        (["--ais"], "--ais needs --mmsi ROBOT=MMSI: an MMSI is assigned, never invented."),
        (["--ais", "--mmsi", "aqua_1=12"], "give ROBOT=MMSI with nine digits"),
        (["--mmsi", "aqua_1=211234567"], "no output; give --cot"),
        (["--target-absolute", "aqua_1", "--target-absolute", "aqua_1"], "give each robot once"),
        (["--nmea", "aqua_1", "--rate", "0"], "--rate must be above 0"),
        (["--gps-input", "aqua_1", "--satellites", "300"], "--satellites must be 0 to 254"),
    ],
)
def test_what_cannot_be_sent_is_one_sentence(capsys, arguments, sentence):
    assert cli.main(["stream", *arguments]) == 2
    assert sentence in capsys.readouterr().err
