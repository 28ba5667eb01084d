# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Conversion of altitudes between datums, to above the WGS84 ellipsoid."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.config.telemetry import FixConfig, HeightConfig
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.values.samples import Fix


def ellipsoidal_altitude(fix: Fix, config: FixConfig) -> float:
    """Return a fix's altitude above the ellipsoid, m; NaN if unknown.

    Args:
        fix: with a position on Earth.
        config: with `altitude_datum`.
    """
    if config.altitude_datum == "ellipsoid":
        return fix.altitude
    if config.altitude_datum == "amsl":
        return fix.altitude + undulation(fix.latitude, fix.longitude)
    if config.altitude_datum == "home":
        return fix.altitude + config.home_altitude_m
    return math.nan


def describe_datums(fix: Fix, config: FixConfig, height: HeightConfig) -> str:
    """Return a sentence for the log on the altitude's datum and the height's source.

    Args:
        fix: the first one, for the undulation at its position.
        config: of the fix.
        height: of the height.
    """
    return f"{_altitude_words(fix, config)}; {_height_words(height)}."


def _altitude_words(fix: Fix, config: FixConfig) -> str:
    datum = config.altitude_datum
    if datum == "ellipsoid":
        return "Altitude of the fix: above the WGS84 ellipsoid, used directly"
    if datum == "amsl":
        metres = undulation(fix.latitude, fix.longitude)
        return f"Altitude of the fix: above mean sea level, which EGM96 puts at {metres:.2f} m here"
    if datum == "home" and not math.isnan(config.home_altitude_m):
        return f"Altitude of the fix: above home, at {config.home_altitude_m:.2f} m"
    if datum == "home":
        return "Altitude of the fix: above home, whose own altitude is not given"
    return "Altitude of the fix: from an unknown datum, not used"


def _height_words(height: HeightConfig) -> str:
    if height.source == "none":
        return "height: the fix's altitude less surface.altitude, in that same datum"
    if height.source == "constant":
        return f"height: always {height.value_m:g} m"
    reference = "the water" if height.reference == "water" else "home, less water_level"
    if height.home_topic:
        return f"height: {height.topic} less {height.home_topic}, above {reference}"
    slant = " along the body, corrected by its tilt" if height.along == "body" else ""
    return f"height: {height.topic} above {reference}{slant}"
