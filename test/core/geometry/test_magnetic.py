# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Declination against the test values that NOAA publishes with the World Magnetic Model."""

from __future__ import annotations

import datetime as dt
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry import frames, magnetic
from aerial_gnss_ros.core.values.errors import InputError


def _stamp(year, month=1, day=1):
    return int(dt.datetime(year, month, day, tzinfo=dt.timezone.utc).timestamp()) * 10**9


@pytest.mark.parametrize(
    ("year", "lat", "lon", "expected_deg"),
    [
        # WMM2020testvalues.pdf and WMM2025_TestValues.txt, altitude 0
        (2020, 80, 0, -1.28),
        (2020, 0, 120, 0.16),
        (2020, -80, 240, 69.36),
        (2025, 80, 0, 1.28),
        (2025, 0, 120, -0.16),
        (2025, -80, 240, 68.78),
    ],
)
def test_declination_is_noaas(year, lat, lon, expected_deg):
    got = magnetic.declination(math.radians(lat), math.radians(lon), _stamp(year))
    assert math.degrees(got) == pytest.approx(expected_deg, abs=0.011)


def test_years_have_fractions():
    assert magnetic.decimal_year(_stamp(2024, 7, 2)) == pytest.approx(2024.5)
    assert magnetic.decimal_year(_stamp(2025)) == 2025.0


def test_the_last_day_covered_works_and_the_next_is_refused():
    magnetic.declination(0.2, -1.0, _stamp(2029, 12, 31))
    for stamp in (0, _stamp(2030), _stamp(2009, 12, 31)):
        with pytest.raises(InputError, match="covers 2010 to 2030"):
            magnetic.declination(0.2, -1.0, stamp)


def test_unknown_altitude_counts_as_sea_level():
    known = magnetic.declination(0.2, -1.0, _stamp(2025), 0.0)
    assert magnetic.declination(0.2, -1.0, _stamp(2025), math.nan) == known


def test_east_declination_turns_the_nose_clockwise():
    # compass says north, magnetic north lies 15 deg east of true: the nose points to heading 15
    body = frames.matrix_from_rpy(0.1, 0.2, frames.yaw_from_heading(0.0))
    true = magnetic.true_from_magnetic(body, math.radians(15.0))
    heading = frames.heading_from_yaw(frames.yaw_of(true))
    assert math.degrees(heading) == pytest.approx(15.0)
    assert frames.rpy_from_matrix(true)[:2] == pytest.approx(np.array([0.1, 0.2]))
