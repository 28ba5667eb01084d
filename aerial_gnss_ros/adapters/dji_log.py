# SPDX-License-Identifier: Apache-2.0
"""DJI flight-record CSV to core values: the only place that knows its columns, units and signs."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.core.frames import matrix_from_rpy, quaternion_from_matrix, yaw_from_heading
from aerial_gnss_ros.core.values import Array, Fix, Orientation, Scalar

ROW_RATE_HZ = 10.0
"""DJI flight records are decoded to ten rows a second; used where no time column says otherwise."""

METRES_PER_FOOT = 0.3048

_REQUIRED = ("latitude", "longitude", "height", "pitch", "yaw", "gimbal_pitch")
_PATTERNS = {
    "latitude": r"(osd\.)?latitude",
    "longitude": r"(osd\.)?longitude",
    "height": r"(osd\.)?height \[(ft|m)\]",
    "altitude": r"(osd\.)?altitude \[(ft|m)\]",
    "pitch": r"(osd\.)?pitch",
    "roll": r"(osd\.)?roll",
    "yaw": r"(osd\.)?yaw( \[360\])?",
    "gimbal_pitch": r"gimbal\.pitch",
    "gimbal_roll": r"gimbal\.roll",
    "gimbal_yaw": r"gimbal\.yaw( \[360\])?",
    "time": r"(osd\.)?flytime \[s\]",
}
_EXPECTED = (
    "OSD.latitude, OSD.longitude, OSD.height [ft] or [m] (or OSD.altitude), OSD.pitch, "
    "OSD.yaw or OSD.yaw [360], GIMBAL.pitch"
)


@dataclass(frozen=True)
class RefusedRow:
    """A row that gives no telemetry: its line in the file (the header is line 1) and why."""

    line: int
    reason: str


@dataclass(frozen=True)
class DjiLog:
    """A flight as recorded, in SI and this package's frames; refused rows are left out.

    Attributes:
        path: the file.
        stamps_ns: (n,) time since the file's first row, ns, strictly increasing.
        latitude: (n,) rad, WGS84.
        longitude: (n,) rad, WGS84.
        height: (n,) m; what it is measured from is DJI's, see `statements`.
        attitude: (n, 4) quaternions x, y, z, w of the body, FLU in ENU.
        gimbal: (n, 4) quaternions x, y, z, w of the camera, FLU in ENU (earth-referenced).
        refused: rows that give nothing.
        statements: how each column was understood, in words for the user.
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

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def fixes(self, start_ns: int = 0) -> list[Fix]:
        """Return the positions; altitude is NaN, for the log's datum is not stated."""
        return [
            Fix(start_ns + int(stamp), float(lat), float(lon), math.nan)
            for stamp, lat, lon in zip(self.stamps_ns, self.latitude, self.longitude, strict=True)
        ]

    def attitudes(self, start_ns: int = 0) -> list[Orientation]:
        """Return the body's orientations, FLU in ENU."""
        return self._orientations(self.attitude, start_ns)

    def gimbals(self, start_ns: int = 0) -> list[Orientation]:
        """Return the camera's orientations, FLU in ENU."""
        return self._orientations(self.gimbal, start_ns)

    def heights(self, start_ns: int = 0) -> list[Scalar]:
        """Return the heights, m."""
        return [
            Scalar(start_ns + int(stamp), float(value))
            for stamp, value in zip(self.stamps_ns, self.height, strict=True)
        ]

    def _orientations(self, quaternions: Array, start_ns: int) -> list[Orientation]:
        return [
            Orientation(start_ns + int(stamp), quaternion)
            for stamp, quaternion in zip(self.stamps_ns, quaternions, strict=True)
        ]


def read_dji_log(path: str | Path, rate_hz: float = ROW_RATE_HZ) -> DjiLog:
    """Read a DJI flight-record CSV as decoded by the usual tools.

    DJI's angles are NED and ZYX; the gimbal's pitch is relative to the ground (OSDK manual) and
    -90 deg looks straight down. Where the gimbal's yaw is not recorded it follows the nose, as in
    DJI's follow mode; where a roll is not recorded it is zero.

    Args:
        path: the CSV.
        rate_hz: rows a second, where there is no column `OSD.flyTime [s]`.

    Raises:
        InputError: no such file, missing columns (found and expected are listed), or no good row.
    """
    path = Path(path)
    header, rows, first_line = _read_rows(path)
    columns = _match_columns(path, header)
    values, refused = _numbers(rows, columns, header, first_line, rate_hz)
    if len(values["time"]) < 2:
        why = f" ({summarise_refusals(refused)})" if refused else ""
        raise InputError(
            f"{path} has {len(values['time'])} usable rows, and a flight needs two{why}."
        )
    yaw = yaw_from_heading(np.radians(values["yaw"]))
    gimbal_yaw = (
        yaw_from_heading(np.radians(values["gimbal_yaw"])) if ("gimbal_yaw" in columns) else yaw
    )
    return DjiLog(
        path=path,
        stamps_ns=np.round(values["time"] * 1e9).astype(np.int64),
        latitude=np.radians(values["latitude"]),
        longitude=np.radians(values["longitude"]),
        height=values["height"],
        attitude=_quaternions(values["roll"], values["pitch"], yaw),
        gimbal=_quaternions(values["gimbal_roll"], values["gimbal_pitch"], gimbal_yaw),
        refused=tuple(refused),
        statements=_statements(columns, header, rate_hz),
    )


def summarise_refusals(refused: Sequence[RefusedRow], most: int = 5) -> str:
    """Return refused rows in words: the count for each reason and the first few line numbers."""
    by_reason: dict[str, list[int]] = {}
    for row in refused:
        by_reason.setdefault(row.reason, []).append(row.line)
    parts = []
    for reason, lines in by_reason.items():
        shown = ", ".join(str(line) for line in lines[:most])
        more = ", …" if len(lines) > most else ""
        rows = "row" if len(lines) == 1 else "rows"
        at = "line" if len(lines) == 1 else "lines"
        parts.append(f"{len(lines)} {rows}: {reason} ({at} {shown}{more})")
    return "; ".join(parts)


def _read_rows(path: Path) -> tuple[list[str], list[list[str]], int]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}.") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            f"{path} is not a CSV text file ({error}); export the flight record as CSV first."
        ) from error
    skip = 1 if rows and ",".join(rows[0]).startswith("sep=") else 0
    if len(rows) <= skip:
        raise InputError(f"{path} is empty; expected a header with {_EXPECTED}.")
    return [name.strip() for name in rows[skip]], rows[skip + 1 :], skip + 2


def _match_columns(path: Path, header: list[str]) -> dict[str, int]:
    columns: dict[str, int] = {}
    for wanted, pattern in _PATTERNS.items():
        for index, name in enumerate(header):
            if re.fullmatch(pattern, name, re.IGNORECASE):
                columns.setdefault(wanted, index)
    if "height" not in columns and "altitude" in columns:
        columns["height"] = columns["altitude"]
    missing = [name for name in _REQUIRED if name not in columns]
    if missing:
        words = ", ".join(name.replace("gimbal_", "GIMBAL.") for name in missing)
        raise InputError(
            f"{path} has no column for {words}; found: {', '.join(header) or 'nothing'}; "
            f"expected: {_EXPECTED}."
        )
    return columns


def _numbers(
    rows: list[list[str]],
    columns: dict[str, int],
    header: list[str],
    first_line: int,
    rate_hz: float,
) -> tuple[dict[str, Array], list[RefusedRow]]:
    """Return named columns (n,) of the good rows (height in m, the rest as recorded)."""
    names = [*_REQUIRED, "roll", "gimbal_roll", "gimbal_yaw", "time"]
    kept: list[list[float]] = []
    refused: list[RefusedRow] = []
    scale = METRES_PER_FOOT if header[columns["height"]].lower().endswith("[ft]") else 1.0
    last_time = -math.inf
    for index, row in enumerate(rows):
        line = first_line + index
        try:
            value = {name: float(row[columns[name]]) if name in columns else 0.0 for name in names}
        except (ValueError, IndexError):
            refused.append(RefusedRow(line, "a value is missing or not a number"))
            continue
        if "time" not in columns:
            value["time"] = index / rate_hz
        value["height"] *= scale
        reason = _refusal(value, last_time)
        if reason:
            refused.append(RefusedRow(line, reason))
            continue
        last_time = value["time"]
        kept.append([value[name] for name in names])
    table = np.array(kept, dtype=np.float64).reshape(-1, len(names))
    return {name: table[:, i] for i, name in enumerate(names)}, refused


def _refusal(value: dict[str, float], last_time: float) -> str | None:
    if not all(math.isfinite(number) for number in value.values()):
        return "a value is missing or not a number"
    if value["height"] < 0.0:
        return "negative height"
    if abs(value["latitude"]) > 90.0 or abs(value["longitude"]) > 180.0:
        return "latitude or longitude out of range"
    if value["latitude"] == 0.0 and value["longitude"] == 0.0:
        return "position 0, 0: no fix"
    if value["time"] <= last_time:
        return "time does not increase"
    return None


def _quaternions(roll_deg: Array, pitch_deg: Array, yaw: Array) -> Array:
    """Return FLU in ENU from DJI's roll, pitch (NED: nose up positive) and the ENU yaw."""
    matrices = matrix_from_rpy(np.radians(roll_deg), -np.radians(pitch_deg), yaw)
    return np.asarray(quaternion_from_matrix(matrices), dtype=np.float64)


def _statements(columns: dict[str, int], header: list[str], rate_hz: float) -> tuple[str, ...]:
    name = header[columns["height"]]
    unit = "feet, converted to m" if name.lower().endswith("[ft]") else "m"
    kind = (
        "above sea level by DJI's own reckoning from the take-off point, and taken as height above "
        "the water (the log states no tide)"
        if "altitude" in name.lower()
        else "above the take-off point, and taken as height above the water; if you took off from "
        "higher up, give the water level"
    )
    time = header[columns["time"]] if "time" in columns else f"row number at {rate_hz:g} Hz"
    absent = [
        words
        for key, words in (
            ("roll", "body roll: 0"),
            ("gimbal_roll", "gimbal roll: 0"),
            ("gimbal_yaw", "gimbal yaw: the aircraft's heading"),
        )
        if key not in columns
    ]
    attitude = (
        f"attitude: {header[columns['yaw']]} is compass heading, {header[columns['pitch']]} nose "
        "up positive (NED); given as body FLU in ENU"
    )
    gimbal = (
        f"gimbal: {header[columns['gimbal_pitch']]} is relative to the ground (earth-referenced), "
        "-90 deg is straight down; given as camera FLU in ENU"
    )
    assumed = (f"not recorded, so assumed: {'; '.join(absent)}",) if absent else ()
    return f"height: {name} ({unit}), {kind}", attitude, gimbal, f"time: {time}", *assumed
