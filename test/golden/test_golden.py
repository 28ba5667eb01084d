# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Replays give what they gave: names, states and refusals equal, positions to a millimetre.

README.md beside this file says how a change of results is recorded. With
AERIAL_GNSS_GOLDEN_BYTES=1 tables must be equal to the byte, too: on the machine that recorded.
"""

from __future__ import annotations

import os
import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.bags.reader import open_bag

HERE = Path(__file__).parent
RECORD = runpy.run_path(str(HERE / "record.py"))
CASES, HEADS = RECORD["CASES"], RECORD["HEADS"]
difference, read, row = RECORD["difference"], RECORD["read"], RECORD["row"]


@pytest.mark.parametrize("case", CASES)
def test_replay_gives_what_is_recorded(case):
    found = difference(read(case), RECORD["replayed"](case))
    table = f"\n{' | '.join(HEADS)}\n{row(case, found)}\npython test/golden/record.py {case}"
    assert found.same, table
    if os.environ.get("AERIAL_GNSS_GOLDEN_BYTES") == "1":
        assert found.bytes_equal, table


def test_record_and_bags_stay_small():
    files = [*HERE.glob("bags/*"), *HERE.glob("records/*")]
    assert {path.stem for path in files} == {bag for bag, _ in CASES.values()} | set(CASES)
    assert sum(path.stat().st_size for path in files) < 3_000_000


def test_record_covers_what_it_is_for():
    many = read("many")
    at_once = max(np.unique([stamp for stamp, *_ in many.rows], return_counts=True)[1])
    assert at_once > 32  # more than one block of the filter
    dives = {name for _, name, _, state in read("dives").rows if state == "coasting"}
    assert len(dives) == 3
    assert {"leader"} < {name for _, name, _, _ in read("crossing").rows}
    reasons = {reason for _, reason, _, _ in read("airframe").refused}
    assert {"wrong_class", "low_score", "gap_fix", "stale_fix", "bad_fix"} <= reasons


def test_result_is_read_as_written(tmp_path, monkeypatch):
    kept = (HERE / "records/glitch.npz").read_bytes()
    old = read("glitch")
    monkeypatch.setitem(RECORD["write"].__globals__, "RECORDS", tmp_path)
    RECORD["write"]("glitch", old)
    assert (tmp_path / "glitch.npz").read_bytes() == kept


def _changed(kind):
    """Return a recorded result and one that differs from it in one way."""
    old = read("glitch")
    rows, numbers = list(old.rows), {name: one.copy() for name, one in old.numbers.items()}
    refused = list(old.refused)
    if kind == "lost":
        rows, numbers = rows[:-1], {name: one[:-1] for name, one in numbers.items()}
    elif kind == "renamed":
        rows = [(t, name.replace("aqua_1", "aqua_9"), *rest) for t, name, *rest in rows]
    elif kind == "state":
        rows[7] = (*rows[7][:3], "confirmed" if rows[7][3] == "coasting" else "coasting")
    elif kind == "refusal":
        refused[0] = (refused[0][0], "low_score", *refused[0][2:])
    elif kind == "latitude":
        numbers["latitude"][5] += 40  # 4.4 mm
    elif kind == "longitude":
        numbers["longitude"][5] -= 40
    elif kind == "sigma":
        numbers["sigma_north"][5] += 40  # 4 mm
    elif kind == "velocity":
        numbers["velocity_east"][5] -= 40
    elif kind == "last bits":
        numbers["latitude"][5] += 5
    return old, replace(old, rows=rows, numbers=numbers, refused=refused)


@pytest.mark.parametrize(
    "kind",
    ["lost", "renamed", "state", "refusal", "latitude", "longitude", "sigma", "velocity"],
)
def test_every_difference_is_found(kind):
    old, new = _changed(kind)
    assert not difference(old, new).same
    assert not difference(new, old).same


def test_last_bits_pass():
    old, new = _changed("last bits")
    found = difference(old, new)
    assert found.same
    assert 0.0005 < found.place_m < 0.0006


def test_bags_can_be_made_again(tmp_path, monkeypatch):
    made = runpy.run_path(str(HERE / "make_bags.py"))
    monkeypatch.setitem(made["make"].__globals__, "BAGS", tmp_path)
    path = made["make"]("jump")
    with open_bag([path]) as new, open_bag([HERE / "bags" / path.name]) as old:
        assert {name: topic.count for name, topic in new.topics.items()} == {
            name: topic.count for name, topic in old.topics.items()
        }
    assert set(made["STORIES"]) == {bag for bag, _ in CASES.values()}
