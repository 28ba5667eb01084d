# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss replay --each`: several flights, each by itself; and what a replay may leave out."""

from __future__ import annotations

import filecmp
from collections import Counter

import pytest

from aerial_gnss_ros.bags.replay import Summary
from aerial_gnss_ros.commands.replay_summary import as_json, as_text

QUICK = ("--no-bag", "--no-figures")


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_each_flight_has_the_result_that_it_has_alone(tmp_path, flight, replay, capsys, jobs):
    first, second = flight.write(tmp_path / "first"), flight.write(tmp_path / "second")
    assert replay(first, tmp_path / "alone", *QUICK) == 0
    bags = [first, tmp_path / "none", second]
    assert replay(bags, tmp_path / "out", "--each", "-j", jobs, *QUICK) == 2
    captured = capsys.readouterr()
    assert "out/first: 20 images, 2 robots" in captured.out
    assert f"aerial-gnss: {tmp_path / 'none'}: " in captured.err
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["first", "second"]
    for name in ("first", "second"):
        one = tmp_path / "out" / name / "positions.csv"
        assert filecmp.cmp(one, tmp_path / "alone/positions.csv", shallow=False)


def test_what_is_not_wanted_is_left_out(tmp_path, flight, replay):
    bag = flight.write(tmp_path / "bag")
    assert replay(bag, tmp_path / "full") == 0
    assert replay(bag, tmp_path / "quick", *QUICK) == 0
    left_out = {path.name for path in (tmp_path / "full").iterdir()}
    left_out -= {path.name for path in (tmp_path / "quick").iterdir()}
    assert left_out == {"bag"}
    pictures = [(tmp_path / name / "report.html").read_text().count("data:image")
                for name in ("full", "quick")]  # fmt: skip
    assert pictures[0] > 0 == pictures[1]


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["-j", "2"], "-j has a meaning only with --each"),
        (["--each", "-j", "0"], "-j must lie within 1 to 64, not 0"),
    ],
)
def test_jobs_are_of_several_flights(tmp_path, flight, refusal, more, sentence):
    bag = flight.write(tmp_path / "bag")
    assert sentence in refusal(bag, tmp_path / "out", *more)


def test_results_of_one_name_are_refused(tmp_path, flight, refusal):
    bags = [flight.write(tmp_path / folder / "bag") for folder in ("monday", "tuesday")]
    assert "two bags are called bag" in refusal(bags, tmp_path / "out", "--each")


def test_the_summary_has_the_names_of_the_truth(tmp_path):
    summary = Summary(frames=1, positions=Counter({"aqua_1": 1, "aqua_2": 1}))
    text = as_text(tmp_path, summary, {"aqua_1": "buoy"})
    assert "1 position, truly buoy" in text
    assert "1 position, no true robot" in text
    assert as_json(tmp_path, summary, {"aqua_1": "buoy"})["truth"] == {"aqua_1": "buoy"}
    assert "true" not in as_text(tmp_path, summary)
