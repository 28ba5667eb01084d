# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A published position as fields of AIS messages, for a plotter; never for a transmitter."""

from __future__ import annotations

import math
import re
from typing import Any

from aerial_gnss_ros.adapters.sightings import Sighting

ACCURATE_M = 10.0
"""AIS calls a position accurate when its error is below this."""

_SPEED_UNKNOWN, _COURSE_UNKNOWN, _HEADING_UNKNOWN = 102.3, 360.0, 511


def position_report(seen: Sighting, mmsi: int) -> dict[str, Any]:
    """Return a class B position report (18); speed, course and heading are unknown."""
    return {
        "type": 18,
        "mmsi": mmsi,
        "lat": math.degrees(seen.latitude),
        "lon": math.degrees(seen.longitude),
        "accuracy": int(2.0 * math.sqrt(2.0) * seen.sigma < ACCURATE_M),
        "speed": _SPEED_UNKNOWN,
        "course": _COURSE_UNKNOWN,
        "heading": _HEADING_UNKNOWN,
        # 62: estimated, by dead reckoning.
        "second": seen.stamp_ns // 1_000_000_000 % 60 if seen.measured else 62,
        "cs": 1,
    }


def static_report(seen: Sighting, mmsi: int) -> dict[str, Any]:
    """Return a static report (24 A): the name, in AIS's 20 capital letters."""
    name = "/".join([*([seen.namespace] if seen.namespace else []), seen.robot_id])
    letters = re.sub(r"[^A-Z0-9/_ -]", " ", name.upper())
    return {"type": 24, "mmsi": mmsi, "partno": 0, "shipname": letters[:20]}
