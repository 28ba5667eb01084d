# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The judge of the fault matrix, with figures that can be checked by hand."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import fault_cases
import fault_kinds
import fault_table
import faults
from fault_flights import Item
from fault_judge import Row, judged, robots_of_names

from aerial_gnss_ros.core.values.samples import Fix, Scalar


def flight() -> list[Row]:
    """Two robots measured each second of 12 s, one sigma off, sigma 1 m."""
    return [
        Row(float(t), f"aqua_{robot + 1}", robot, 1.0, 1.0, 1.0, True)
        for t in range(12)
        for robot in range(2)
    ]


def changed(rows: list[Row], which, **values) -> list[Row]:
    return [replace(row, **values) if which(row) else row for row in rows]


def test_a_flight_that_nothing_befalls_is_right_and_the_same():
    verdict = judged(flight(), flight(), 4.0, 6.0)
    assert verdict.same
    assert (verdict.wrong, verdict.kept, verdict.names, verdict.right_s) == (0, 2, 2, 0.0)
    assert (verdict.rows, verdict.during, verdict.after, verdict.sigma) == (16, 4, 12, 1.0)
    assert verdict.most_sigmas == 1.0


def test_wrong_is_what_is_confident_and_right_without_the_fault():
    """13.9 is beyond 13.8; robot 1 is so at 9 s without the fault too, and 3 s is before it."""
    far = {"squared": 13.9, "error_m": 7.0}
    wrong = changed(flight(), lambda row: row.t in {3.0, 5.0, 9.0}, **far)
    clean = changed(flight(), lambda row: row.t == 9.0 and row.robot == 1, **far)
    verdict = judged(wrong, clean, 4.0, 6.0)
    assert (verdict.wrong, verdict.most_m, verdict.rows) == (3, 7.0, 16)
    assert verdict.most_sigmas == pytest.approx(math.sqrt(13.9))
    assert not verdict.same
    just = changed(flight(), lambda row: row.t == 5.0, squared=13.8)
    assert judged(just, flight(), 4.0, 6.0).wrong == 0
    nothing = changed(flight(), lambda row: row.t == 5.0, squared=math.nan)
    assert judged(nothing, flight(), 4.0, 6.0).wrong == 2


def test_it_is_right_again_when_all_robots_are_measured_and_right_for_a_second():
    """The fault ends at 4 s; robot 0 comes back at 6 s, is wrong at 7 s, and right from 8 s on."""
    rows = [row for row in flight() if row.robot == 1 or not 4.0 <= row.t < 6.0]
    rows = changed(rows, lambda row: row.t == 7.0 and row.robot == 0, squared=20.0)
    assert judged(rows, flight(), 3.0, 4.0).right_s == 4.0
    coasting = changed(rows, lambda row: row.robot == 1, confirmed=False)
    assert math.isnan(judged(coasting, flight(), 3.0, 4.0).right_s)


def test_sigma_counts_from_three_seconds_after_the_fault():
    rows = changed(flight(), lambda row: row.t < 7.0, sigma_m=50.0)
    assert judged(rows, flight(), 3.0, 4.0).sigma == 1.0
    rows = changed(rows, lambda row: row.t >= 7.0, sigma_m=3.0)
    assert judged(rows, flight(), 3.0, 4.0).sigma == 3.0


def test_a_name_is_kept_that_is_on_its_robot_at_the_end():
    renamed = changed(flight(), lambda row: row.t >= 5.0 and row.robot == 0, name="aqua_3")
    assert judged(renamed, flight(), 4.0, 6.0).kept == 1
    elsewhere = changed(flight(), lambda row: row.t >= 5.0 and row.robot == 0, squared=99.0)
    assert judged(elsewhere, flight(), 4.0, 6.0).kept == 1
    gone = [row for row in flight() if row.t < 5.0 or row.robot == 1]
    assert judged(gone, flight(), 4.0, 6.0).kept == 1
    late = [row for row in flight() if row.t >= 2.0]  # the fault is there from the start
    assert judged(late, flight(), 0.0, 2.0).kept == 2


def test_a_late_name_is_identified_by_its_formation_where_the_receiver_is_off():
    robots = np.array([[0.0, 0.0], [4.0, 0.0], [20.0, 0.0]])

    def published(beside):
        """Three from the start, `late` from 8 s on, on robot 1; all 2.5 m too far west."""
        for i in range(150):
            names = {"a": 0, "b": 2, "gone": 1} if i < 80 else {"late": 1} | beside
            for name, robot in names.items():
                yield 0.1 * i, name, True, robots[robot] - [2.5, 0.0] - robots

    assert robots_of_names(published({"b": 2})) == {"a": 0, "b": 2, "gone": 1, "late": 1}
    assert robots_of_names(published({"a": 0, "b": 2}))["late"] == 1
    # Whatever the other names are on: exchanged ones mislead nobody.
    assert robots_of_names(published({"a": 2, "b": 0}))["late"] == 1
    near = [(0.1 * i, "late", True, np.array([1.0, 0.0]) - robots) for i in range(20)]
    assert (
        robots_of_names([*published({}), *((t + 30.0, "alone", *two) for t, _, *two in near)])[
            "alone"
        ]
        == 0
    )  # no other sign


def fixes(count: int) -> list[Item]:
    return [
        Item(k * 100_000_000, "fix", Fix(k * 100_000_000, 0.23, -1.0, 5.0)) for k in range(count)
    ]


def test_faults_are_as_they_are_called():
    rng = np.random.default_rng(1)
    made = {kind: change(fixes(11), rng) for kind, change in fault_kinds.KINDS.items()}
    assert not made["absent"]
    assert {item.arrival_ns - item.value.stamp_ns for item in made["late"]} == {10**9}
    assert len(made["duplicated"]) == 22
    assert sorted(item.value.stamp_ns for item in made["out of order"]) == [
        item.value.stamp_ns for item in fixes(11)
    ]
    assert [item.value.stamp_ns for item in made["out of order"]] != [
        item.value.stamp_ns for item in fixes(11)
    ]
    assert all(math.isnan(item.value.latitude) for item in made["NaN"])
    east = [
        (item.value.longitude + 1.0) * 6_371_000.0 * math.cos(0.23) for item in made["slow drift"]
    ]
    assert east == pytest.approx([0.1 * k for k in range(11)], abs=1e-6)  # 1 m/s
    assert {item.value.stamp_ns for item in made["frozen stamp"]} == {0}
    assert {item.value.stamp_ns - item.arrival_ns for item in made["stamp a day off"]} == {
        86_400 * 10**9
    }
    off = [item.value.longitude != -1.0 for item in made["one wild sample"]]
    assert off == [k == 5 for k in range(11)]


def test_a_fault_lasts_from_its_begin_to_its_end():
    flown = fault_cases.flown("hover", 1)
    case = fault_cases.Case("height: stuck at 1 m", fault_cases._stuck(1.0))
    start = fault_cases.START_NS
    stuck = [
        (item.arrival_ns - start) * 1e-9
        for item in case.items(flown, 1)
        if isinstance(item.value, Scalar) and item.value.value == 1.0
    ]
    assert (min(stuck), max(stuck)) == pytest.approx((15.02, 19.92))
    assert len(stuck) == 50


def test_flights_go_on_where_the_file_ends(tmp_path, monkeypatch, capsys):
    verdict = judged(flight(), flight(), 4.0, 6.0).record()
    begun = []

    def record(job):
        begun.append(job)
        died = "ValueError: no" if job[0] == "fix: NaN" else ""
        return {"case": job[0], "flight": job[1], "seed": job[2], **verdict, "died": died}

    monkeypatch.setattr(faults, "record", record)
    path = tmp_path / "f.jsonl"
    command = ["faults.py", "--flown", str(path), "--flights", "orbit", "--only", "fix:Na,fix:abs"]
    monkeypatch.setattr(sys, "argv", command)
    faults.main()
    assert begun == [("fix: absent", "orbit", 1), ("fix: NaN", "orbit", 1)]
    assert len([json.loads(line) for line in path.read_text().splitlines()]) == 2
    monkeypatch.setattr(sys, "argv", [*command, "--seeds", "2", "--failing"])
    capsys.readouterr()
    faults.main()
    assert begun[2:] == [("fix: absent", "orbit", 2), ("fix: NaN", "orbit", 2)]
    table = [row for row in capsys.readouterr().out.splitlines() if row.startswith("|")]
    assert [row.split(" | ")[0] for row in table[:1] + table[2:]] == ["| fault", "| fix: NaN"]
    assert fault_table.troubles({"case": "attitude: zero", **verdict, "died": ""}) == []
    changed_one = {"case": "attitude: zero", **verdict, "died": "", "same": False}
    assert fault_table.troubles(changed_one) == ["changed"]


def test_cases_have_names_of_their_own():
    words = [case.words for case in fault_cases.cases()]
    assert len(words) == len(set(words))
    assert {"fix: zero", "attitude in use: jump", "images: late"} <= set(words)


@pytest.mark.parametrize("words", ["attitude in use: jump", "gimbal + height: jump"])
def test_all_robots_are_right_within_three_seconds_of_a_jump_back(words):
    """What was found meanwhile under a new label must not keep its box from the robot."""
    case = next(one for one in fault_cases.cases() if one.words == words)
    verdict, run = fault_cases.fly(case, "transit", 1)
    assert not run.died
    assert (verdict.wrong, verdict.kept) == (0, verdict.names)
    assert verdict.right_s <= 3.0
