# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names and units of the columns of flight-record CSV, by exporter.

Supported are flight records decoded by the common viewers (`OSD.height [ft]`), by command-line
parsers (`OSD.height`, metres) and by AirData (`height_above_takeoff(feet)`). All have DJI's angles.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from aerial_gnss_ros.adapters.dji_flight import METRES_PER_FOOT
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import cut

REQUIRED = ("latitude", "longitude", "height", "pitch", "yaw", "gimbal_pitch")
_LENGTH = r"( ?[\[(](?P<unit>ft|feet|m|meters?|metres?)[\])])?"
_ANGLE = r"( ?[\[(](deg|degrees|360)[\])])?"
# The first pattern that a column matches is used, so less ambiguous names come first.
_PATTERNS: dict[str, tuple[str, ...]] = {
    "latitude": (r"(osd\.)?latitude",),
    "longitude": (r"(osd\.)?longitude",),
    "height": (r"(osd\.)?height" + _LENGTH, r"height_above_takeoff" + _LENGTH),
    "altitude": (r"(osd\.)?altitude" + _LENGTH, r"altitude_above_sealevel" + _LENGTH),
    "pitch": (r"(osd\.)?pitch" + _ANGLE,),
    "roll": (r"(osd\.)?roll" + _ANGLE,),
    "yaw": (r"(osd\.)?yaw" + _ANGLE, r"compass_heading" + _ANGLE),
    "gimbal_pitch": (r"gimbal[._]pitch" + _ANGLE,),
    "gimbal_roll": (r"gimbal[._]roll" + _ANGLE,),
    "gimbal_yaw": (r"gimbal[._](yaw|heading)" + _ANGLE,),
    "time_s": (r"(osd\.)?flytime \[s\]",),
    "time_ms": (r"time\(milliseconds?\)",),
    "time_text": (r"(osd\.)?flytime",),
    "video": (r"(camera\.)?is(taking)?video",),
    "clock": (r"datetime\(utc\)", r"custom\.datetime( \[utc\])?"),
    "date": (r"custom\.date \[utc\]",),
    "time_of_day": (r"custom\.updatetime \[utc\]",),
    "local_date": (r"custom\.date \[local\]", r"datetime\(local\)"),
}
EXPECTED = (
    "OSD.latitude, OSD.longitude, OSD.height [ft] or [m] (or OSD.altitude), OSD.pitch, "
    "OSD.yaw or OSD.yaw [360], GIMBAL.pitch; or AirData's latitude, longitude, "
    "height_above_takeoff(feet), pitch(degrees), compass_heading(degrees), gimbal_pitch(degrees)"
)
_SHOWN = 60
_POINTS = str.maketrans(",.", ".,")
"""A point beside a decimal comma separates thousands; as a comma it makes no number."""


@dataclass(frozen=True)
class Columns:
    """Positions of the values in a row.

    Attributes:
        header: the file's own names.
        index: column by quantity.
        metres: factor that converts the height to metres.
        unit: its unit in words.
        decimal_comma: whether numbers have a comma where others have a point.
    """

    header: tuple[str, ...]
    index: dict[str, int]
    metres: float
    unit: str
    decimal_comma: bool = False

    def __contains__(self, wanted: str) -> bool:
        return wanted in self.index

    def name(self, wanted: str) -> str:
        """Return the file's own name of a column."""
        return self.header[self.index[wanted]]

    def text(self, wanted: str, row: Sequence[str]) -> str:
        """Return a field's text; empty if the row is too short."""
        place = self.index[wanted]
        return row[place].strip() if place < len(row) else ""

    def numeral(self, wanted: str, row: Sequence[str]) -> str:
        """Return a field's text with a decimal point."""
        text = self.text(wanted, row)
        return text.translate(_POINTS) if self.decimal_comma else text

    def for_rows(self, rows: Sequence[Sequence[str]]) -> Columns:
        """Return the columns with the decimal sign of a file's rows.

        A latitude has no thousands to separate, so a comma in one is a decimal comma.
        """
        latitudes = [self.text("latitude", row) for row in rows]
        commas, points = (sum(sign in text for text in latitudes) for sign in ",.")
        return replace(self, decimal_comma=commas > points)


def match_columns(path: Path, header: Sequence[str]) -> Columns:
    """Return the columns of a header.

    Raises:
        InputError: a required column is missing; the message lists found and expected ones.
    """
    index: dict[str, int] = {}
    units: dict[str, str] = {}
    for wanted, patterns in _PATTERNS.items():
        for pattern in patterns:
            found = _find(pattern, header)
            if found is not None and wanted not in index:
                index[wanted], units[wanted] = found
    if "height" not in index and "altitude" in index:
        index["height"], units["height"] = index["altitude"], units["altitude"]
    missing = [name for name in REQUIRED if name not in index]
    if missing:
        words = ", ".join(name.replace("gimbal_", "GIMBAL.") for name in missing)
        more = f" and {len(header) - _SHOWN} more" if len(header) > _SHOWN else ""
        shown = ", ".join(map(cut, header[:_SHOWN])) or "nothing"
        raise InputError(
            f"{path} has no column for {words}; found: {shown}{more}; expected: {EXPECTED}."
        )
    feet = units["height"].lower().startswith("f")
    unit = "feet, converted to m" if feet else "m"
    if not units["height"]:
        unit = "m"
    return Columns(tuple(header), index, METRES_PER_FOOT if feet else 1.0, unit)


def has_unit(columns: Columns) -> bool:
    """Whether the header names the height's unit."""
    return re.search(r"[\[(]\w+[\])]$", columns.name("height")) is not None


def seconds(columns: Columns, row: Sequence[str], index: int, rate_hz: float) -> float:
    """Return a row's time in s.

    Raises:
        ValueError: the field is not a time.
    """
    if "time_s" in columns:
        return float(columns.numeral("time_s", row))
    if "time_ms" in columns:
        return float(columns.numeral("time_ms", row)) * 1e-3
    if "time_text" in columns:
        return _duration(columns.numeral("time_text", row))
    return index / rate_hz


def is_true(text: str) -> bool:
    """Whether a field is affirmative: True, 1, Yes, Recording."""
    return text.lower() in ("true", "1", "1.0", "yes", "recording", "starting")


def _find(pattern: str, header: Sequence[str]) -> tuple[int, str] | None:
    for place, name in enumerate(header):
        match = re.fullmatch(pattern, name, re.IGNORECASE)
        if match:
            return place, (match.groupdict().get("unit") or "")
    return None


def _duration(text: str) -> float:
    """Return seconds of `12.3`, `1m 2.3s` or `0:01:02.3`."""
    match = re.fullmatch(r"(?:(\d+)h ?)?(?:(\d+)m ?)?([\d.]+)s", text)
    if match:
        return 3600.0 * int(match[1] or 0) + 60.0 * int(match[2] or 0) + float(match[3])
    total = 0.0
    for part in text.split(":"):
        total = 60.0 * total + float(part)
    return total
