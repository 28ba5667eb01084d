# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Altitudes above the ellipsoid, by what they are measured from."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from aerial_gnss_ros.core.config.telemetry import FixConfig, HeightConfig
from aerial_gnss_ros.core.telemetry.vertical_datum import describe_datums, ellipsoidal_altitude
from aerial_gnss_ros.core.values.samples import Fix

BARBADOS = Fix(0, math.radians(13.25), math.radians(-59.75), 30.0)
UNDULATION_M = -47.44
"""EGM96 there: a point of NGA's grid."""
FIX, HEIGHT = FixConfig(), HeightConfig()


@pytest.mark.parametrize(
    ("datum", "home_m", "altitude"),
    [
        ("ellipsoid", math.nan, 30.0),
        ("amsl", math.nan, 30.0 + UNDULATION_M),
        ("home", -40.0, -10.0),
        ("home", math.nan, math.nan),
        ("unknown", -40.0, math.nan),
    ],
)
def test_each_datum_has_its_way_to_the_ellipsoid(datum, home_m, altitude):
    config = replace(FIX, altitude_datum=datum, home_altitude_m=home_m)
    found = ellipsoidal_altitude(BARBADOS, config)
    assert found == pytest.approx(altitude, abs=0.01, nan_ok=True)


@pytest.mark.parametrize(
    ("fix", "height", "words"),
    [
        ({"altitude_datum": "ellipsoid"}, {}, "above the WGS84 ellipsoid, used directly"),
        ({"altitude_datum": "amsl"}, {}, "which EGM96 puts at -47.44 m"),
        ({"altitude_datum": "home", "home_altitude_m": 12.0}, {}, "at 12.00 m"),
        ({"altitude_datum": "home"}, {}, "whose own altitude is not given"),
        ({"altitude_datum": "unknown"}, {}, "from an unknown datum, not used"),
        ({}, {"source": "none"}, "less surface.altitude, in that same datum"),
        ({}, {"source": "constant", "value_m": 12.5}, "height: always 12.5 m"),
        ({}, {"topic": "h", "reference": "water"}, "height: h above the water"),
        ({}, {"topic": "h", "reference": "home"}, "height: h above home, less water_level"),
        ({}, {"topic": "h", "home_topic": "g"}, "height: h less g, above "),
        ({}, {"topic": "h", "along": "body"}, "along the body, corrected by its tilt."),
    ],
)
def test_the_log_says_what_altitudes_are_measured_from(fix, height, words):
    said = describe_datums(BARBADOS, replace(FIX, **fix), replace(HEIGHT, **height))
    assert words in said
    assert said.endswith(".")
