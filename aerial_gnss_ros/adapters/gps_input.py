# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A published position as MAVLink GPS_INPUT (232), a GNSS receiver to a robot's autopilot."""

from __future__ import annotations

import math
from typing import Any

from aerial_gnss_ros.adapters.nmea import hdop
from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.core.geometry.geoid import undulation

GPS_EPOCH_NS = 315_964_800_000_000_000
LEAP_SECONDS = 18  # GPS less UTC since 2017
WEEK_NS = 604_800_000_000_000

IGNORE_ALTITUDE, IGNORE_VDOP = 1, 4
IGNORE_VELOCITY = 8 | 16 | 32  # horizontal, vertical, and its accuracy
IGNORE_VERTICAL_ACCURACY = 128
FIX_2D, FIX_3D = 2, 3

VERTICAL_M = 5.0
"""One sigma of a known altitude: that of the drone's receiver."""


def gps_input(seen: Sighting, satellites: int) -> dict[str, Any]:
    """Return the fields of a GPS_INPUT.

    The fix is 3D if the altitude is known (above mean sea level by EGM96), else 2D. Velocity is
    left out: a NavSatFix has none.

    Args:
        seen: a measured position; coasting robots must not be sent.
        satellites: a constant; the message has no value for unknown.
    """
    known = math.isfinite(seen.altitude)
    ignored = IGNORE_VDOP | IGNORE_VELOCITY
    altitude = 0.0
    if known:
        altitude = seen.altitude - undulation(seen.latitude, seen.longitude)
    else:
        ignored |= IGNORE_ALTITUDE | IGNORE_VERTICAL_ACCURACY
    week, in_week = divmod(seen.stamp_ns - GPS_EPOCH_NS + LEAP_SECONDS * 1_000_000_000, WEEK_NS)
    return {
        "time_usec": seen.stamp_ns // 1000,
        "gps_id": 0,
        "ignore_flags": ignored,
        "time_week_ms": in_week // 1_000_000,
        "time_week": week,
        "fix_type": FIX_3D if known else FIX_2D,
        "lat": round(math.degrees(seen.latitude) * 1e7),
        "lon": round(math.degrees(seen.longitude) * 1e7),
        "alt": altitude,
        "hdop": hdop(seen.sigma),
        "vdop": 99.9,
        "vn": 0.0,
        "ve": 0.0,
        "vd": 0.0,
        "speed_accuracy": 0.0,
        "horiz_accuracy": math.sqrt(2.0) * seen.sigma,
        "vert_accuracy": VERTICAL_M if known else 0.0,
        "satellites_visible": satellites,
    }
