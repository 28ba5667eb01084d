# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The cost of snapshots is that of the guard's own ones."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import scaling

from aerial_gnss_ros.core.estimation import guard
from aerial_gnss_ros.core.estimation.snapshot import Snapshot


def held(robots):
    """Return what a row says of the objects, arrays and containers that are kept."""
    cells = scaling.guard_row(robots, 12).strip("| ").split(" | ")
    assert int(cells[0]) == robots
    assert 0 < int(cells[2]) <= int(cells[1])
    return [int(cell) for cell in cells[4:]]


def test_more_robots_are_more_to_keep():
    one, three = held(1), held(3)
    assert three[0] == one[0] + 2  # a track each
    assert three[1:] == one[1:]  # that hold nothing to copy
    assert len(scaling.TimedSnapshot.spent) == 12
    assert guard.Snapshot is Snapshot
