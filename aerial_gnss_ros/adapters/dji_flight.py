# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A flight recorded by a DJI drone, in SI units and this package's frames."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar
from aerial_gnss_ros.text.sentences import counted

METRES_PER_FOOT = 0.3048
HEIGHT_GUESS = (
    "height: assumed to be above the water, which the log does not know; if you took off from "
    "higher up, or the tide changed, import again with --water-level, the water's level above the "
    "take-off point"
)
BELOW_HOME = (
    "height: down to {lowest:.1f} m, which is below the take-off point: you took off above the "
    "water, from a cliff, a pier or a deck. These are heights above home. Give the water level "
    "relative to the take-off point, here a negative number (about {example:g} m or less), when "
    "you import (--water-level) or in a --params file (height: {{reference: home}}, water_level: "
    "{{value_m: {example:g}}}): height above water = height - water_level"
)
LONGEST_STEP_S = 1.0
"""Rows farther apart than this are reported as a gap: telemetry is not interpolated far, s."""
LAST_TIME_S = 1e7
"""A later time in a log (four months) means damage, s."""
HIGHEST_M = 10_000.0
"""A height farther from the take-off point means damage, m."""
MOST_ANGLE_DEG = 360.0


@dataclass(frozen=True)
class RefusedRow:
    """A row without usable telemetry: its line (the header is line 1) and the reason."""

    line: int
    reason: str


@dataclass(frozen=True)
class DjiLog:
    """A recorded flight in SI units and this package's frames, without refused rows.

    Attributes:
        path: the file.
        stamps_ns: (n,) time since the file's first row, ns, strictly increasing.
        latitude: (n,) rad, WGS84.
        longitude: (n,) rad, WGS84.
        height: (n,) m, above the datum in `statements`, mostly the take-off point, below which it
            is negative. NaN in rows without one; (0,) if all are.
        attitude: (n, 4) quaternions x, y, z, w of the body, FLU in ENU; (0, 4) where absent.
        gimbal: (n, 4) quaternions of the camera, FLU in ENU (earth-referenced); (0, 4) likewise.
        refused: rows without usable telemetry.
        statements: interpretation of each column, in words for the user.
        guesses: assumptions about what the file leaves open, in words.
        recordings_s: (start, end) of each video recording that the log marks, s.
        clock_ns: Unix time of the file's first row, ns, if the file has it in UTC; else None.
        of_video: whether the times are the video's own (subtitles).
    """

    path: Path
    stamps_ns: NDArray[np.int64]
    latitude: Array
    longitude: Array
    height: Array
    attitude: Array
    gimbal: Array
    refused: tuple[RefusedRow, ...]
    statements: tuple[str, ...]
    guesses: tuple[str, ...] = ()
    recordings_s: tuple[tuple[float, float], ...] = ()
    clock_ns: int | None = None
    of_video: bool = False

    def __len__(self) -> int:
        return len(self.stamps_ns)

    @property
    def seconds(self) -> Array:
        """Times (n,) in s since the file's first row."""
        return np.asarray(self.stamps_ns * 1e-9)

    @property
    def lowest(self) -> float:
        """The least height, m; NaN without heights."""
        return float(np.nanmin(self.height)) if len(self.height) else math.nan

    def chosen(self, rows: NDArray[np.bool_]) -> DjiLog:
        """Return the flight with only the rows selected by a mask (n,)."""
        columns = ("stamps_ns", "latitude", "longitude", "height", "attitude", "gimbal")
        kept = {name: getattr(self, name) for name in columns}
        return replace(self, **{name: v[rows] if len(v) else v for name, v in kept.items()})

    @property
    def gaps_s(self) -> tuple[tuple[float, float], ...]:
        """Gaps between rows: (time of the last row before, length), s."""
        seconds = self.seconds
        lengths = np.diff(seconds)
        usual = float(np.median(lengths)) if len(lengths) else 0.0
        long = np.flatnonzero(lengths > max(LONGEST_STEP_S, 5.0 * usual))
        return tuple((float(seconds[i]), float(lengths[i])) for i in long)

    def fixes(self, start_ns: int = 0) -> list[Fix]:
        """Return the positions; the altitude is NaN because the log does not state its datum."""
        return [
            Fix(start_ns + int(stamp), float(lat), float(lon), math.nan)
            for stamp, lat, lon in zip(self.stamps_ns, self.latitude, self.longitude, strict=True)
        ]

    def attitudes(self, start_ns: int = 0) -> list[Orientation]:
        """Return the body's orientations, FLU in ENU; empty if the log has none."""
        return self._orientations(self.attitude, start_ns)

    def gimbals(self, start_ns: int = 0) -> list[Orientation]:
        """Return the camera's orientations, FLU in ENU; empty if the log has none."""
        return self._orientations(self.gimbal, start_ns)

    def heights(self, start_ns: int = 0) -> list[Scalar]:
        """Return the heights, m, of the rows that have one."""
        if not len(self.height):
            return []
        return [
            Scalar(start_ns + int(stamp), float(value))
            for stamp, value in zip(self.stamps_ns, self.height, strict=True)
            if math.isfinite(value)
        ]

    def _orientations(self, quaternions: Array, start_ns: int) -> list[Orientation]:
        if not len(quaternions):
            return []
        return [
            Orientation(start_ns + int(stamp), quaternion)
            for stamp, quaternion in zip(self.stamps_ns, quaternions, strict=True)
        ]


def summarise_refusals(refused: Sequence[RefusedRow], most: int = 5) -> str:
    """Return refused rows in words: the count for each reason and the first few line numbers."""
    by_reason: dict[str, list[int]] = {}
    for row in refused:
        by_reason.setdefault(row.reason, []).append(row.line)
    parts = []
    for reason, lines in by_reason.items():
        shown = ", ".join(str(line) for line in lines[:most])
        more = ", …" if len(lines) > most else ""
        at = "line" if len(lines) == 1 else "lines"
        parts.append(f"{counted(len(lines), 'row')}: {reason} ({at} {shown}{more})")
    return "; ".join(parts)


def height_guess(lowest: float) -> str:
    """Return what is assumed of the heights, in words.

    Args:
        lowest: the least of them, m.
    """
    if lowest >= 0.0:
        return HEIGHT_GUESS
    return BELOW_HOME.format(lowest=lowest, example=math.floor(lowest) - 1)


def quaternions(roll_deg: Array, pitch_deg: Array, yaw: Array) -> Array:
    """Return FLU in ENU (n, 4) from DJI's roll and pitch (NED: nose up positive) and ENU yaw."""
    matrices = matrix_from_rpy(np.radians(roll_deg), -np.radians(pitch_deg), yaw)
    return np.asarray(quaternion_from_matrix(matrices), dtype=np.float64)


def range_refusal(time_s: float, height: float, angles_deg: Iterable[float]) -> str | None:
    """Return why a row's numbers cannot be what they are said to be, or None.

    Args:
        time_s: since the log's zero, s.
        height: m; NaN where there is none.
        angles_deg: NaN where there is none.
    """
    if not 0.0 <= time_s <= LAST_TIME_S:
        return "time out of range"
    if abs(height) > HIGHEST_M:
        return "height out of range"
    if any(abs(angle) > MOST_ANGLE_DEG for angle in angles_deg):
        return "an angle out of range"
    return None


def position_refusal(latitude_deg: float, longitude_deg: float) -> str | None:
    """Return why a position is invalid, or None."""
    if not (math.isfinite(latitude_deg) and math.isfinite(longitude_deg)):
        return "a value is missing or not a number"
    if abs(latitude_deg) > 90.0 or abs(longitude_deg) > 180.0:
        return "latitude or longitude out of range"
    if latitude_deg == 0.0 and longitude_deg == 0.0:
        return "position 0, 0: no fix"
    return None
