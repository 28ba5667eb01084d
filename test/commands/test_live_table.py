# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The demo's table: positions as they come, with their errors."""

from __future__ import annotations

import io

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.commands.live_table import live_table, rows
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu

LATITUDE, LONGITUDE = np.radians([13.19, -59.64])


def track(east, count=3):
    """Return positions so far east of the truth, 0.1 s apart, with sigmas of 3 m and 1 m."""
    latitude, longitude, _ = geodetic_from_enu(
        np.full(count, east), np.zeros(count), np.zeros(count), LATITUDE, LONGITUDE, 0.0
    )
    return EstimatedTrack(
        np.arange(count) * 100_000_000, np.asarray(latitude), np.asarray(longitude),
        np.tile(np.diag([9.0, 1.0]), (count, 1, 1)), np.ones(count, bool),
    )  # fmt: skip


TRUTH = {"boat": Track(*(getattr(track(0.0), n) for n in ("stamps_ns", "latitude", "longitude")))}


def test_a_row_is_the_newest_position_with_its_sigma_and_its_error():
    (row,) = rows({"aqua_1": track(1.5)}, TRUTH)
    assert row[0] == "aqua_1"
    assert [float(row[1]), float(row[2])] == pytest.approx([13.19, -59.64], abs=2e-5)
    assert row[3:] == ("2.24 m", "1.50 m")  # the root of (9 + 1) / 2
    assert rows({"aqua_1": track(1.5)}, {})[0][4] == "–"


def test_without_a_terminal_lines_come_every_two_seconds():
    stream = io.StringIO()
    with live_table(TRUTH, stream) as show:
        show(0.0, {})
        for elapsed_s in (0.5, 1.9, 2.0, 2.1):
            show(elapsed_s, {"aqua_1": track(0.0)})
    lines = stream.getvalue().splitlines()
    assert lines[0] == "  0.0 s  no robot yet"
    assert [line[:5] for line in lines[1:]] == ["  2.0"]
    assert "one sigma 2.24 m  error 0.00 m" in lines[1]
