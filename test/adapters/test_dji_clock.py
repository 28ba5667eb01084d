# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When a DJI log began: found in columns of whole seconds, and in spite of wrong dates."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_log import read_dji_log

FLIGHT = np.arange(0.0, 20.0, 0.1)


TRUE_NS = 1_657_483_182_730_000_000


def airdata(path, dates):
    """An AirData table of `FLIGHT` with these dates, each in whole seconds."""
    header = (
        "time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),"
        "compass_heading(degrees),pitch(degrees),gimbal_pitch(degrees)\n"
    )
    times = zip(FLIGHT, dates, strict=True)
    rows = [f"{round(t * 1000)},{date},13.2,-59.6,100,270,0,-30\n" for t, date in times]
    path.write_text(header + "".join(rows))
    return path


def whole_seconds(start_ns):
    seconds = (start_ns + np.round(FLIGHT * 1e9).astype(np.int64)) // 10**9
    return [f"{np.datetime64(int(s), 's')}".replace("T", " ") for s in seconds]


@pytest.mark.parametrize("phase_ns", [0, 20_000_000, 500_000_000, 990_000_000])
def test_the_start_is_found_in_a_column_of_whole_seconds(tmp_path, phase_ns):
    """One row is up to a second late; where the second changes is known to a tenth."""
    start_ns = TRUE_NS // 10**9 * 10**9 + phase_ns
    log = read_dji_log(airdata(tmp_path / "a.csv", whole_seconds(start_ns)))
    assert abs(log.clock_ns - start_ns) <= 50_000_000


def test_a_few_wrong_dates_move_nothing(tmp_path):
    dates = whole_seconds(TRUE_NS)
    dates[:30] = ["2022-07-10 07:59:42"] * 30  # before the drone knew the time
    dates[100:103] = ["", "nonsense", "9999-12-31 23:59:59"]
    log = read_dji_log(airdata(tmp_path / "a.csv", dates))
    assert abs(log.clock_ns - TRUE_NS) <= 50_000_000


@pytest.mark.parametrize("date", ["0001-01-01T00:00:00+14:00", "9999-12-31 23:59:59", "9" * 999])
def test_dates_that_no_drone_wrote_are_none(tmp_path, date):
    assert read_dji_log(airdata(tmp_path / "a.csv", [date] * len(FLIGHT))).clock_ns is None
