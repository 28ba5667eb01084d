# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights of the benchmarks are kept and taken up again; tables use seeds that every cell has."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import accuracy
import consistency
import flown


def record(cell, seed, _setting):
    squares = {"released": 9.0, "paper": 4.0, "single": 4.0, "ours": 1.0 + seed, "bound": 1.0,
               "published": 1.0}  # fmt: skip
    return {"cell": cell.words, "seed": seed, "nees": {"10": 2.0 + seed}, "nees_all": [2.0, 4.0],
            "squares": {name: 2.0 * value for name, value in squares.items()}, "samples": 2,
            "extra_names": 0, "core_ms": 1.0}  # fmt: skip


def test_flights_go_on_where_the_file_ends(tmp_path, monkeypatch):
    begun = []
    monkeypatch.setattr(flown, "fly", lambda *flight: begun.append(flight[:2]) or record(*flight))
    given = argparse.Namespace(
        flights=tmp_path / "f.jsonl", first=0, seeds=1, minutes=60.0, only="hover 10 m,rtk",
        markdown=None,
    )  # fmt: skip
    flights = flown.flown(given)
    assert [(cell.words, seed) for cell, seed in begun] == [
        ("hover 10 m rtk still", 0), ("hover 10 m rtk moving", 0)
    ]  # fmt: skip
    lines = given.flights.read_text().splitlines()
    given.flights.write_text("\n".join(lines) + "\n")
    given.seeds = 2
    flights = flown.flown(given)
    assert [seed for _, seed in begun] == [0, 0, 1, 1]
    assert [one["seed"] for one in flights["hover 10 m rtk still"]] == [0, 1]
    given.minutes = 0.0  # no time for seed 2: tables stay with the two seeds that all cells have
    given.seeds = 3
    flights = flown.flown(given)
    assert len(begun) == 4
    assert {len(one) for one in flights.values()} == {2}
    given.first, given.seeds, given.minutes = 7, 2, 60.0
    assert [one["seed"] for one in flown.flown(given)["hover 10 m rtk still"]] == [7, 8]
    line = accuracy.markdown(flights).splitlines()[2]
    assert line.split(" | ")[1:6] == ["3.00", "2.00", "2.00", "1.22", "1.00"]
    line = consistency.markdown(flights).splitlines()[2]
    assert line.split(" | ")[1:6] == ["2.50 (2)", "–", "–", "3.00", "yes"]


def test_the_band_of_many_flights_is_narrow():
    """By hand (Wilson and Hilferty): 2 (1 - 2/1800 +- 3.50 sqrt(2/1800))^3 at 200 degrees."""
    assert consistency.band(100, 108) == pytest.approx((1.373, 2.777), abs=0.01)
