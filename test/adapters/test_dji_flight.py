# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A DJI flight as recorded: gaps, refused rows, samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_flight import (
    DjiLog,
    RefusedRow,
    position_refusal,
    range_refusal,
    summarise_refusals,
)
from aerial_gnss_ros.adapters.dji_log import read_dji_log


def test_gaps_are_found(tmp_path):
    header = (
        "OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch\n"
    )
    path = tmp_path / "log.csv"
    times = [0.0, 0.1, 0.2, 3.7, 3.8, 9.0]
    path.write_text(header + "".join(f"{t},13,-59,20,0,0,-30\n" for t in times))
    assert read_dji_log(path).gaps_s == (
        (pytest.approx(0.2), pytest.approx(3.5)),
        (pytest.approx(3.8), pytest.approx(5.2)),
    )


def flight(heights):
    """Return a flight of one row each 0.1 s."""
    n = len(heights)
    every = np.arange(n)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    return DjiLog(
        Path("log.csv"), 100_000_000 * every, 0.2 + 1e-6 * every, -1.0 + 1e-6 * every,
        np.array(heights, float), level, np.zeros((0, 4)), (), (),
    )  # fmt: skip


def test_samples_are_stamped_from_the_start_that_is_given():
    log = flight([20.0, np.nan, 21.0])
    assert [one.stamp_ns for one in log.fixes(7)] == [7, 100_000_007, 200_000_007]
    assert (log.fixes()[1].latitude, log.fixes()[1].longitude) == (0.2 + 1e-6, -1.0 + 1e-6)
    assert np.isnan(log.fixes()[0].altitude)
    assert [(one.stamp_ns, one.value) for one in log.heights(7)] == [(7, 20.0), (200_000_007, 21.0)]
    assert len(log.attitudes()) == 3
    assert log.gimbals() == []  # not recorded
    assert log.lowest == 20.0


def test_some_rows_of_a_flight_are_chosen_from_all_columns():
    chosen = flight([20.0, 21.0, 22.0]).chosen(np.array([True, False, True]))
    assert chosen.stamps_ns.tolist() == [0, 200_000_000]
    assert chosen.latitude == pytest.approx([0.2, 0.2 + 2e-6], abs=1e-12)
    assert (chosen.height.tolist(), len(chosen.attitude), len(chosen.gimbal)) == (
        [20.0, 22.0],
        2,
        0,
    )


def test_refused_rows_are_counted_by_reason_with_the_first_lines():
    rows = [RefusedRow(line, "no fix") for line in range(2, 9)] + [RefusedRow(4, "late")]
    assert (
        summarise_refusals(rows, most=3)
        == "7 rows: no fix (lines 2, 3, 4, …); 1 row: late (line 4)"
    )


@pytest.mark.parametrize(
    ("time", "height", "angles", "words"),
    [
        (1e7, 1e4, (360.0, -360.0), None),
        (1.1e7, 0.0, (), "time out of range"),
        (0.0, -10_001.0, (), "height out of range"),
        (0.0, float("nan"), (361.0,), "an angle out of range"),
    ],
)
def test_numbers_out_of_range_are_named(time, height, angles, words):
    assert range_refusal(time, height, angles) == words


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ((90.0, 180.0), None),
        ((90.1, 0.0), "latitude"),
        ((1.0, -180.1), "latitude"),
        ((0, 0), "no fix"),
    ],
)
def test_a_place_that_is_none_is_named(place, words):
    found = position_refusal(*place)
    assert (found is None) == (words is None)
    assert words is None or words in found
