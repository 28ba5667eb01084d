# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Marks survive a kill at any byte; an undo is kept; other recordings are refused."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.teaching.carry import Mark
from aerial_gnss_ros.teaching.project import FILE, Project, Statement


def _said(frame, robot="fin_1", class_name="fin"):
    return Statement(Mark(robot, frame, np.array([10.0, 20.0, 5.0, 4.0])), class_name)


def test_marks_are_there_again_after_any_end(tmp_path):
    """Cut after each byte: all whole lines count, and work goes on behind them."""
    project = Project(tmp_path, "flight.mcap", 9)
    assert project.add(_said(1))
    assert project.add(Statement(Mark("fin_1", 3, None), "fin"))
    assert not project.add(_said(1))  # said before
    whole = (tmp_path / FILE).read_bytes()
    lines = whole.splitlines(keepends=True)
    for end in range(len(whole) + 1):
        folder = tmp_path / f"cut_{end}"
        folder.mkdir()
        (folder / FILE).write_bytes(whole[:end])
        again = Project(folder, "flight.mcap", 9)
        complete = sum(end >= sum(map(len, lines[: i + 1])) for i in range(1, len(lines)))
        assert len(again.marks) == complete
        assert again.add(_said(5))
        assert [m.frame for m in Project(folder, "flight.mcap", 9).marks][-1] == 5


def test_an_undo_is_kept(tmp_path):
    project = Project(tmp_path, "flight.mcap", 9)
    project.add(_said(1))
    project.add(_said(2, "fin_2"))
    assert project.undo().mark.robot == "fin_2"
    again = Project(tmp_path, "flight.mcap", 9)
    assert (list(again.classes), [m.frame for m in again.marks]) == (["fin_1"], [1])
    assert again.undo() is not None
    assert again.undo() is None


@pytest.mark.parametrize(
    ("name", "count", "words"),
    [("other.mcap", 9, "marks of 'flight.mcap' with 9 frames, not of 'other.mcap'"),
     ("flight.mcap", 8, "with 9 frames, not of 'flight.mcap' with 8")],
)  # fmt: skip
def test_marks_of_another_recording_are_refused(tmp_path, name, count, words):
    Project(tmp_path, "flight.mcap", 9).add(_said(1))
    with pytest.raises(InputError, match=words):
        Project(tmp_path, name, count)


@pytest.mark.parametrize(
    "line",
    ["nonsense", "[1]", '{"robot": "a"}', '{"robot": "a", "class": "b", "frame": 1, "box": [1]}'],
)
def test_a_damaged_line_is_named(tmp_path, line):
    Project(tmp_path, "flight.mcap", 9).add(_said(1))
    with (tmp_path / FILE).open("a") as file:
        file.write(line + "\n")
    with pytest.raises(InputError, match=r"marks\.jsonl, line 3, is damaged"):
        Project(tmp_path, "flight.mcap", 9)


def test_frames_and_classes_are_checked(tmp_path):
    project = Project(tmp_path, "flight.mcap", 9)
    with pytest.raises(InputError, match="frame 9 does not exist; the recording has frames 0 to 8"):
        project.add(_said(9))
    project.add(_said(0))
    with pytest.raises(InputError, match="is of class 'fin', not 'cat'"):
        project.add(_said(1, class_name="cat"))
