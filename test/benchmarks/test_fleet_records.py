# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names stand for the robots they are used for, and rows and sentences say what flights were."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from fleet_names import agreement, robots_by_name
from fleet_records import HEADS, Record, pooled, row


def test_a_name_stands_for_the_robot_it_is_used_for_most_often():
    used = [("one", 0), ("one", 0), ("one", 1), ("two", 1), (None, 2)]
    assert robots_by_name(used) == {"one": 0, "two": 1}


def test_a_second_name_of_a_robot_and_one_that_nobody_knows_do_not_agree():
    used = [("one", 0), ("one", 0), ("two", 0), (None, 0), ("three", 1)]
    assert agreement(used) == pytest.approx(3 / 5)
    assert agreement([]) == 0.0


def flight(share, together, expected, expected_nees):
    """Return a flight whose bound is 1 m, and whose best estimate errs by 2 m."""
    return Record(
        0, 0, share, together, (9.0,), 1.0, 4.0, 1.5, 3, 3, 2.0, 1.0,
        best=4.0, best_nees=1.0, expected=expected, expected_nees=expected_nees,
    )  # fmt: skip


def test_a_row_has_the_flight_beside_its_bound_the_best_estimate_and_what_is_expected():
    flights = [flight(share, 4.41, 1.21, share + 0.4) for share in (0.0, 0.5, 1.0)]
    found = dict(zip(HEADS, row("hover", flights, 3), strict=True))
    assert found["RMS / bound"] == "2.10"
    assert found["RMS / best"] == "1.05"
    assert found["expected / bound"] == "1.10"
    assert [found[name] for name in ("expected: share 0", "0.5", "1")] == ["0.40", "0.90", "1.40"]
    assert found["joined"] == "3 of 3"


def test_a_row_is_judged_by_what_is_expected_and_luck_is_told_beside_it():
    lucky = [flight(share, 0.5, 1.69, 2.5) for share in (0.0, 0.5, 1.0)]
    good = [flight(share, 4.0, 1.0, 1.0) for share in (0.0, 0.5, 1.0)]
    words = pooled([lucky, good])
    assert "Of 2 rows, 1 are expected to be within 1.15 of the bound" in words
    assert "2 are within that of the best estimate, 1 of the bound itself" in words
    assert "in 1 of 2 rows, and in 3 of 6 rows of one share" in words
