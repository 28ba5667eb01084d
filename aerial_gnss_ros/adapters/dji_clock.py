# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Start time of a flight record, from its column of UTC dates."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, timezone

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.dji_columns import Columns
from aerial_gnss_ros.core.values.samples import Array

_SECOND_NS = 1_000_000_000
_EARLIEST_S, _LATEST_S = 946_684_800, 2_100_000_000
"""2000 to 2036: before, there were no such drones; later, no valid ROS stamps."""
_FORMS = ("%m/%d/%Y %I:%M:%S.%f %p", "%m/%d/%Y %I:%M:%S %p", "%Y/%m/%d %H:%M:%S.%f")


def log_start_ns(columns: Columns, rows: Sequence[Sequence[str]], times: Array) -> int | None:
    """Return the Unix time of the log's time zero, ns; None if no column has it.

    Some exporters write whole seconds. Where such a column changes, the second begins between the
    previous row and this one. The median over all changes is accurate to half the row interval and
    robust against a wrong date; a single row would be wrong by up to a second.

    Args:
        columns: of the file.
        rows: the n rows.
        times: (n,) of the rows in the log's own time, s.
    """
    known: dict[str, int | None] = {}
    clock_ns = [_utc_ns(columns, row, known) for row in rows]
    use = np.array([at is not None for at in clock_ns], dtype=np.bool_)
    if not use.any():
        return None
    clock = np.array([at for at in clock_ns if at is not None], dtype=np.int64)
    log = np.round(times[use] * 1e9).astype(np.int64)
    whole = bool((clock % _SECOND_NS == 0).all())
    starts = _at_changes(clock, log) if whole else clock - log
    first = int(clock[0] - log[0])
    # Of differences: a float has no nanoseconds of the Unix time.
    return first + round(float(np.median(starts - first))) if len(starts) else first


def _at_changes(clock: NDArray[np.int64], log: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return (k,) estimates of the log's start from the changes of a clock of whole seconds, ns."""
    steps = np.diff(log)
    usual = float(np.median(steps)) if len(steps) else 0.0
    changed = np.flatnonzero((np.diff(clock) > 0) & (steps < 1.5 * usual))  # not across a gap
    return np.asarray(clock[changed + 1] - (log[changed] + log[changed + 1]) // 2)


def _utc_ns(columns: Columns, row: Sequence[str], known: dict[str, int | None]) -> int | None:
    """Return a row's Unix time in ns if the file has it in UTC; `known` is a cache across rows.

    A date repeats in several rows, and parsing one takes longer than the rest of a row.
    """
    if "clock" in columns:
        text = columns.text("clock", row)
    elif "date" in columns and "time_of_day" in columns:
        text = f"{columns.text('date', row)} {columns.text('time_of_day', row)}"
    else:
        return None
    if text not in known:
        known[text] = _moment_ns(text)
    return known[text]


def _moment_ns(text: str) -> int | None:
    moment = _parse_moment(text[:60])
    try:
        at = moment.timestamp() if moment is not None else 0.0
    except (OverflowError, ValueError):  # the year 1 in another zone
        return None
    return round(at * 1e6) * 1000 if _EARLIEST_S <= at <= _LATEST_S else None


def _parse_moment(text: str) -> datetime | None:
    text = text.strip().replace("Z", "+00:00")
    text = re.sub(r"(\.\d{6})\d+", r"\1", text)
    moment: datetime | None = None
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        moment = next((m for form in _FORMS if (m := _strptime(text, form))), None)
    if moment is None or moment.tzinfo is not None:
        return moment
    return moment.replace(tzinfo=timezone.utc)


def _strptime(text: str, form: str) -> datetime | None:
    try:
        return datetime.strptime(text, form).replace(tzinfo=timezone.utc)
    except ValueError:
        return None
