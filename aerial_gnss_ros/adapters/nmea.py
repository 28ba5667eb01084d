# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A published position as NMEA 0183 sentences, for plotters and programs that read a receiver."""

from __future__ import annotations

import math
from datetime import datetime, timezone

from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.core.geometry.geoid import undulation

USER_RANGE_ERROR_M = 5.0
"""Error in metres per unit of HDOP, for a receiver without corrections."""

_MEASURED, _ESTIMATED = "1", "6"  # GGA's quality: GPS fix; dead reckoning


def gga(seen: Sighting) -> str:
    """Return a GGA sentence; quality 6, estimated, while the robot is coasting.

    The altitude is above mean sea level (EGM96); it and the geoid separation are empty if unknown.
    The number of satellites is empty, too.
    """
    altitude = separation = ""
    if math.isfinite(seen.altitude):
        geoid = undulation(seen.latitude, seen.longitude)
        altitude, separation = f"{seen.altitude - geoid:.1f}", f"{geoid:.1f}"
    place = (*_angle(seen.latitude, "N", "S", 2), *_angle(seen.longitude, "E", "W", 3))
    quality = _MEASURED if seen.measured else _ESTIMATED
    rest = ("", f"{hdop(seen.sigma):.1f}", altitude, "M", separation, "M", "", "")
    return _sentence("GPGGA", _time(seen), *place, quality, *rest)


def rmc(seen: Sighting) -> str:
    """Return an RMC sentence; status V and mode E, estimated, while the robot is coasting.

    Speed and course are empty: the message has none.
    """
    place = (*_angle(seen.latitude, "N", "S", 2), *_angle(seen.longitude, "E", "W", 3))
    status, mode = ("A", "A") if seen.measured else ("V", "E")
    date = f"{_date(seen):%d%m%y}"
    return _sentence("GPRMC", _time(seen), status, *place, "", "", date, "", "", mode)


def hdop(sigma: float) -> float:
    """Return the HDOP of one sigma per axis, m: 99.9 if it is unknown or larger."""
    value = math.sqrt(2.0) * sigma / USER_RANGE_ERROR_M
    return min(max(value, 0.1), 99.9) if math.isfinite(value) else 99.9


def _sentence(*fields: str) -> str:
    text = ",".join(fields)
    checksum = 0
    for character in text.encode("ascii"):
        checksum ^= character
    return f"${text}*{checksum:02X}\r\n"


def _date(seen: Sighting) -> datetime:
    return datetime.fromtimestamp(seen.stamp_ns // 1_000_000_000, tz=timezone.utc)


def _time(seen: Sighting) -> str:
    return f"{_date(seen):%H%M%S}.{seen.stamp_ns // 10_000_000 % 100:02d}"


def _angle(angle: float, positive: str, negative: str, digits: int) -> tuple[str, str]:
    """Return degrees with minutes to 1e-6 (2 mm), and the side, of an angle in rad."""
    millionths = round(abs(math.degrees(angle)) * 60e6)
    degrees, rest = divmod(millionths, 60_000_000)
    minutes, fraction = divmod(rest, 1_000_000)
    side = negative if angle < 0.0 else positive
    return f"{degrees:0{digits}d}{minutes:02d}.{fraction:06d}", side
