# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads DJI logs: flight-record CSV, AirData CSV or SRT subtitles, by the file's name."""

from __future__ import annotations

from pathlib import Path

from aerial_gnss_ros.adapters.dji_csv import read_csv
from aerial_gnss_ros.adapters.dji_flight import DjiLog, RefusedRow, summarise_refusals
from aerial_gnss_ros.adapters.dji_srt import read_srt

__all__ = ["ROW_RATE_HZ", "DjiLog", "RefusedRow", "read_dji_log", "summarise_refusals"]

ROW_RATE_HZ = 10.0
"""Row rate of decoded DJI flight records, Hz; used if there is no time column."""


def read_dji_log(path: str | Path, rate_hz: float = ROW_RATE_HZ) -> DjiLog:
    """Read a DJI flight-record CSV as decoded by the usual tools, AirData's CSV, or SRT subtitles.

    DJI's angles are NED and ZYX; the gimbal's pitch is relative to the ground (OSDK manual) and -90
    deg looks straight down. If the gimbal's yaw is not recorded, it follows the nose, as in DJI's
    follow mode; a roll that is not recorded is zero.

    Args:
        path: the file; one that ends in .srt is read as subtitles.
        rate_hz: row rate if a CSV has no time column, Hz.

    Raises:
        InputError: no such file, missing columns (found and expected ones are listed), or no valid
            row.
    """
    path = Path(path)
    return read_srt(path) if path.suffix.lower() == ".srt" else read_csv(path, rate_hz)
