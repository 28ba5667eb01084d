# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Versions are compared turn by turn, each by its own files."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import against

FLIGHT = """
from pathlib import Path
class Engine:
    def add_detections(self, boxes):
        with Path("seen").open("a") as file:
            file.write(f"{boxes} ")
    def advance(self, stamp_ns):
        sum(range(1000))
def flight(robots, images):
    return Engine(), [(i, robots) for i in range(images)]
"""

LEFT_OUT = """
from contextlib import contextmanager
PARTS = ["a"]
now = "whole"
@contextmanager
def left_out(names):
    global now
    now = "without_" + "_".join(names)
    try:
        yield
    finally:
        now = "whole"
"""


def version(folder: Path, text: str = FLIGHT) -> Path:
    """Return a folder that looks like a version of the program."""
    (folder / "benchmarks").mkdir(parents=True)
    (folder / "benchmarks" / "scaling.py").write_text(text, encoding="utf-8")
    return folder


def test_a_ratio_is_the_median_of_turns_not_of_times():
    times = [(10.0, 5.0), (100.0, 90.0), (1000.0, 400.0), (30.0, 20.0), (8.0, 5.0)]
    found = against.Ratio.of(3, times)
    assert (found.this_us, found.other_us) == (30.0, 20.0)
    assert (found.low, found.ratio, found.high) == (1.5, 1.6, 2.0)
    assert "| 3 | 30 | 20 | 1.60 | 1.50 to 2.00 |" in against.table([found])


def test_both_versions_work_on_all_images_of_their_own_flight(tmp_path, monkeypatch):
    monkeypatch.setattr(against, "MOST", 2)  # so that three turns take two flights
    one, two = version(tmp_path / "one"), version(tmp_path / "two")
    found = against.compared(one, two, 7, 3)
    assert found.ratio > 0.0
    images = (3 + 2 * against.FIRST) * against.IMAGES
    for tree in (one, two):
        assert (tree / "seen").read_text(encoding="utf-8").split() == ["7"] * images


def test_only_this_version_works_without_its_protection(tmp_path):
    flight = FLIGHT.replace("{boxes} ", "{safety_cost.now} ") + "import safety_cost\n"
    one, two = version(tmp_path / "one", flight), version(tmp_path / "two", flight)
    for tree in (one, two):
        (tree / "benchmarks" / "safety_cost.py").write_text(LEFT_OUT, encoding="utf-8")
    against.compared(one, two, 3, 1, ("--unprotected",))
    assert set((one / "seen").read_text(encoding="utf-8").split()) == {"without_a"}
    assert set((two / "seen").read_text(encoding="utf-8").split()) == {"whole"}


def test_a_version_that_fails_is_named(tmp_path):
    with pytest.raises(SystemExit, match="two cannot be measured"):
        against.compared(version(tmp_path / "one"), version(tmp_path / "two", "1 / 0"), 3, 1)


def test_a_folder_without_the_program_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["against.py", str(tmp_path)])
    with pytest.raises(SystemExit) as ended:
        against.main()
    assert ended.value.code == 2
    assert "is no version of the program" in capsys.readouterr().err
