# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads flight-record CSV of several exporters."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.dji_clock import log_start_ns
from aerial_gnss_ros.adapters.dji_columns import (
    EXPECTED,
    REQUIRED,
    Columns,
    has_unit,
    is_true,
    match_columns,
    seconds,
)
from aerial_gnss_ros.adapters.dji_flight import (
    DjiLog,
    RefusedRow,
    height_guess,
    position_refusal,
    quaternions,
    range_refusal,
    summarise_refusals,
)
from aerial_gnss_ros.adapters.text_files import read_text
from aerial_gnss_ros.core.geometry.frames import wrap_angle, yaw_from_heading
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.samples import Array

_NUMBERS = (*REQUIRED, "roll", "gimbal_roll", "gimbal_yaw")
_ANGLES = ("roll", "pitch", "yaw", "gimbal_roll", "gimbal_pitch", "gimbal_yaw")
_MOST_BYTES = 200_000_000
_MOST_COLUMNS = 5000


def read_csv(path: Path, rate_hz: float) -> DjiLog:
    """Read a flight-record CSV; see `dji_log.read_dji_log`."""
    header, rows, first_line = _read_rows(path)
    columns = match_columns(path, header).for_rows(rows)
    values, kept, refused = _numbers(rows, columns, first_line, rate_hz)
    if len(kept) < 2:
        why = f" ({summarise_refusals(refused)})" if refused else ""
        raise InputError(f"{path} has {len(kept)} usable rows, and a flight needs two{why}.")
    heading = np.radians(values["yaw"])
    gimbal_heading, relative = _gimbal_heading(values, columns, heading)
    times = values["time"]
    return DjiLog(
        path=path,
        stamps_ns=np.round(times * 1e9).astype(np.int64),
        latitude=np.radians(values["latitude"]),
        longitude=np.radians(values["longitude"]),
        height=values["height"],
        attitude=quaternions(values["roll"], values["pitch"], yaw_from_heading(heading)),
        gimbal=quaternions(
            values["gimbal_roll"], values["gimbal_pitch"], yaw_from_heading(gimbal_heading)
        ),
        refused=tuple(refused),
        statements=_statements(columns, rate_hz, relative),
        guesses=_guesses(columns, relative, values),
        recordings_s=_recordings(columns, [rows[i] for i in kept], times),
        clock_ns=log_start_ns(columns, [rows[i] for i in kept], times),
    )


def _read_rows(path: Path) -> tuple[list[str], list[list[str]], int]:
    file = io.StringIO(read_text(path, _MOST_BYTES), newline="")
    first = file.readline()
    file.seek(0)
    states = first.startswith("sep=") and len(first.rstrip()) == 5
    separator = first[4] if states else max(",;\t", key=first.count)
    try:
        rows = list(csv.reader(file, delimiter=separator))
    except csv.Error as error:
        raise InputError(
            f"{path} is not a CSV text file ({error}); export the flight record as CSV first."
        ) from error
    skip = 1 if first.startswith("sep=") else 0
    if len(rows) <= skip:
        raise InputError(f"{path} is empty; expected a header with {EXPECTED}.")
    if len(rows[skip]) > _MOST_COLUMNS:
        raise InputError(
            f"{path} has {len(rows[skip])} columns, more than any flight record has; expected a "
            f"header with {EXPECTED}."
        )
    return [name.strip() for name in rows[skip]], rows[skip + 1 :], skip + 2


def _numbers(
    rows: list[list[str]], columns: Columns, first_line: int, rate_hz: float
) -> tuple[dict[str, Array], list[int], list[RefusedRow]]:
    """Return named columns (n,) of the good rows (height in m, the rest as recorded)."""
    table: list[list[float]] = []
    kept: list[int] = []
    refused: list[RefusedRow] = []
    last_time = -math.inf
    for index, row in enumerate(rows):
        try:
            value = {n: float(columns.numeral(n, row)) if n in columns else 0.0 for n in _NUMBERS}
            value["time"] = seconds(columns, row, index, rate_hz)
        except (ValueError, OverflowError):
            refused.append(RefusedRow(first_line + index, "a value is missing or not a number"))
            continue
        value["height"] *= columns.metres
        reason = _refusal(value, last_time)
        if reason:
            refused.append(RefusedRow(first_line + index, reason))
            continue
        last_time = value["time"]
        kept.append(index)
        table.append([*value.values()])
    array = np.array(table, dtype=np.float64).reshape(-1, len(_NUMBERS) + 1)
    return {n: array[:, i] for i, n in enumerate((*_NUMBERS, "time"))}, kept, refused


def _refusal(value: dict[str, float], last_time: float) -> str | None:
    if not all(math.isfinite(number) for number in value.values()):
        return "a value is missing or not a number"
    out_of_range = range_refusal(value["time"], value["height"], (value[name] for name in _ANGLES))
    if out_of_range:
        return out_of_range
    place = position_refusal(value["latitude"], value["longitude"])
    if place:
        return place
    return "time does not increase" if value["time"] <= last_time else None


def _gimbal_heading(
    values: dict[str, Array], columns: Columns, heading: Array
) -> tuple[Array, bool]:
    """Return the camera's compass heading (n,), and whether the file has it relative to the nose.

    DJI's gimbal yaw is from north. Some exporters write it relative to the nose: then it stays near
    zero while the nose turns.
    """
    if "gimbal_yaw" not in columns:
        return heading, False
    own = np.radians(values["gimbal_yaw"])
    near = float(np.percentile(np.abs(wrap_angle(own)), 90.0)) < math.radians(30.0)
    follows = abs(np.mean(np.exp(1j * (own - heading)))) > 0.9
    turned = abs(np.mean(np.exp(1j * heading))) < 0.8
    relative = bool(near and turned and not follows)
    return (heading + own if relative else own), relative


def _most_angle(values: dict[str, Array]) -> float:
    """Return the greatest size of all angles as the file has them."""
    return max(float(np.abs(values[name]).max()) for name in _ANGLES)


def _recordings(
    columns: Columns, rows: list[list[str]], times: Array
) -> tuple[tuple[float, float], ...]:
    """Return the times of video recordings in the log, s."""
    if "video" not in columns:
        return ()
    on: NDArray[np.bool_] = np.array([is_true(columns.text("video", row)) for row in rows])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    last = len(times) - 1
    return tuple(
        (float(times[a]), float(times[min(b, last)]))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    )


def _statements(columns: Columns, rate_hz: float, relative: bool) -> tuple[str, ...]:
    name = columns.name("height")
    kind = (
        "above sea level as DJI computes it from the take-off point"
        if "altitude" in name.lower()
        else "above the take-off point"
    )
    times = [columns.name(t) for t in ("time_s", "time_ms", "time_text") if t in columns]
    time = times[0] if times else f"row number at {rate_hz:g} Hz"
    attitude = (
        f"attitude: {columns.name('yaw')} is compass heading, {columns.name('pitch')} nose "
        "up positive (NED); given as body FLU in ENU"
    )
    gimbal = (
        f"gimbal: {columns.name('gimbal_pitch')} is relative to the ground (earth-referenced), "
        "-90 deg is straight down; given as camera FLU in ENU"
    )
    more = []
    if columns.decimal_comma:
        more.append("numbers: with a decimal comma")
    if "gimbal_yaw" in columns and not relative:
        more.append(f"gimbal yaw: {columns.name('gimbal_yaw')} is from north")
    if "video" in columns:
        more.append(f"recordings: marked by {columns.name('video')}")
    if "clock" in columns or ("date" in columns and "time_of_day" in columns):
        more.append(f"date: {columns.name('clock' if 'clock' in columns else 'date')}, UTC")
    return f"height: {name} ({columns.unit}), {kind}", attitude, gimbal, f"time: {time}", *more


def _guesses(columns: Columns, relative: bool, values: dict[str, Array]) -> tuple[str, ...]:
    absent = [
        words
        for key, words in (
            ("roll", "body roll: 0"),
            ("gimbal_roll", "gimbal roll: 0"),
            ("gimbal_yaw", "gimbal yaw: the aircraft's heading, as in follow mode"),
        )
        if key not in columns
    ]
    guesses = [height_guess(float(values["height"].min()))]
    if absent:
        guesses.append(f"not recorded, so assumed: {'; '.join(absent)}")
    if relative:
        guesses.append(
            f"gimbal yaw: {columns.name('gimbal_yaw')} stays near 0 while the nose turns, so it "
            "is assumed relative to the nose, not to north"
        )
    most_angle = _most_angle(values)
    if most_angle <= math.tau:
        guesses.append(
            f"angles: assumed in degrees, though none is beyond {most_angle:.4g}, so that all "
            "could be radians; if they are, convert them to degrees and import again"
        )
    north, east = (float(np.abs(values[name]).max()) for name in ("latitude", "longitude"))
    if north <= 0.5 * math.pi and east <= math.pi:
        guesses.append(
            f"positions: assumed in degrees, so in the Gulf of Guinea; {north:.4g}, {east:.4g} "
            "could be radians; if they are, convert them to degrees and import again"
        )
    if not has_unit(columns):
        guesses.append(f"height unit: {columns.name('height')} has none, assumed m")
    if "local_date" in columns and "clock" not in columns and "date" not in columns:
        guesses.append(
            f"date: {columns.name('local_date')} is local time of an unknown zone, ignored"
        )
    return tuple(guesses)
