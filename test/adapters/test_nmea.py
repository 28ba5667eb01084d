# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""NMEA 0183 sentences, letter by letter."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from aerial_gnss_ros.adapters.nmea import gga, hdop, rmc

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import SEEN


def checksum(sentence):
    """Return the exclusive or of what stands between $ and *."""
    total = 0
    for letter in sentence[1 : sentence.index("*")]:
        total ^= ord(letter)
    return total


def test_a_position_is_written_in_degrees_and_minutes():
    """0.19394 deg are 11.6364 minutes, 0.64151 deg are 38.4906."""
    place = "1311.636400,N,05938.490600,W"
    fix, course = gga(SEEN), rmc(SEEN)
    assert fix.startswith(f"$GPGGA,221320.12,{place},1,,0.3,,M,,M,,*")
    assert course.startswith(f"$GPRMC,221320.12,A,{place},,,141123,,,A*")
    for sentence in (fix, course):
        assert sentence.endswith(f"*{checksum(sentence):02X}\r\n")


@pytest.mark.parametrize(
    ("latitude", "longitude", "place"),
    [
        (-0.5, 179.999_999_999_9, "0030.000000,S,18000.000000,E"),
        (12.999_999_999_9, -0.25, "1300.000000,N,00015.000000,W"),  # no 60 minutes
    ],
)
def test_minutes_are_rounded_into_degrees(latitude, longitude, place):
    seen = replace(SEEN, latitude=math.radians(latitude), longitude=math.radians(longitude))
    assert place in gga(seen)


def test_a_robot_that_is_not_seen_is_estimated_by_dead_reckoning():
    coasting = replace(SEEN, measured=False)
    assert gga(coasting).split(",")[6] == "6"
    assert (rmc(coasting).split(",")[2], rmc(coasting).split(",")[12][0]) == ("V", "E")


@pytest.mark.parametrize(
    ("sigma", "value"),
    [(5.0, math.sqrt(2.0)), (0.0, 0.1), (1e9, 99.9), (math.nan, 99.9), (math.inf, 99.9)],
)
def test_dilution_is_the_error_over_that_of_a_receiver(sigma, value):
    assert hdop(sigma) == pytest.approx(value)
