# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a training remembers, what it shows ultralytics, and what it leaves for people."""

from __future__ import annotations

from pathlib import Path

import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.held_out import held_out_split
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.phases import Phase
from aerial_gnss_ros.training.run_folder import Plan, RunFolder

PLAN = Plan(
    Path("/somewhere/set/data.yaml"), "abc", False, (Phase("single", 3), Phase("several", 2)),
    "yolo11n.yaml", image_size=64, threads=2,
)  # fmt: skip


def test_a_plan_survives_being_saved(tmp_path):
    run = RunFolder(tmp_path)
    run.save(PLAN)
    assert run.load() == PLAN


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (None, "has no plan.json"),
        ("{", "is damaged"),
        ("[]", "is damaged"),
        ('{"format": 99}', "another version"),
        ('{"format": 1, "phases": []}', "is damaged"),
    ],
)
def test_a_folder_that_is_no_training(tmp_path, content, expected):
    if content is not None:
        (tmp_path / "plan.json").write_text(content)
    with pytest.raises(InputError, match=expected):
        RunFolder(tmp_path).load()


def test_one_training_at_a_time(tmp_path):
    with (
        RunFolder(tmp_path).locked(),
        pytest.raises(InputError, match="another process is training"),
        RunFolder(tmp_path).locked(),
    ):
        pass
    with RunFolder(tmp_path).locked():
        pass


def test_a_split_named_test_is_held_out(tmp_path, make_set):
    found = inspect(open_dataset(make_set(tmp_path / "set", splits=("train", "val", "test"))))
    assert held_out_split(found) == "test"
