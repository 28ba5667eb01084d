# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fields of GPS_INPUT, by its definition in MAVLink's common dialect."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from aerial_gnss_ros.adapters.gps_input import gps_input
from aerial_gnss_ros.core.geometry.geoid import undulation

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import SEEN


def test_a_position_without_altitude_is_a_fix_in_two_dimensions():
    fields = gps_input(SEEN, 12)
    assert (fields["lat"], fields["lon"], fields["satellites_visible"]) == (
        131_939_400, -596_415_100, 12,
    )  # fmt: skip
    # Ignored: altitude, vertical dilution, velocity (3), vertical accuracy.
    assert (fields["fix_type"], fields["ignore_flags"]) == (2, 1 + 4 + 8 + 16 + 32 + 128)
    assert fields["horiz_accuracy"] == pytest.approx(math.sqrt(2.0))  # 1 m each axis


def test_an_altitude_is_above_mean_sea_level():
    fields = gps_input(replace(SEEN, altitude=-40.0), 12)
    assert (fields["fix_type"], fields["ignore_flags"]) == (3, 4 + 8 + 16 + 32)
    assert fields["alt"] == pytest.approx(-40.0 - undulation(SEEN.latitude, SEEN.longitude))
    assert fields["vert_accuracy"] == 5.0


@pytest.mark.parametrize(
    ("unix_s", "week", "ms"),
    [
        (315_964_800, 0, 18_000),  # 1980-01-06; leap seconds of today
        (1_700_000_000, 2288, ((2 * 24 + 22) * 3600 + 13 * 60 + 20 + 18) * 1000),  # a Tuesday
        (1_699_747_181, 2287, 604_799_000),  # the last second of a week
        (1_699_747_182, 2288, 0),
    ],
)
def test_time_is_the_week_of_gps_and_what_has_passed_of_it(unix_s, week, ms):
    fields = gps_input(replace(SEEN, stamp_ns=unix_s * 1_000_000_000), 12)
    assert (fields["time_week"], fields["time_week_ms"]) == (week, ms)
    assert fields["time_usec"] == unix_s * 1_000_000
