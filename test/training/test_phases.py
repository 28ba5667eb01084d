# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which images each phase of the curriculum learns from."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.phases import Phase, members, plan_phases, timed_phase


def names(folder, shows):
    examples = inspect(open_dataset(folder)).examples["train"]
    return "".join(example.image.stem for example in members(Phase(shows, 1), examples))


def test_one_robot_then_several_and_empty_images_in_both(tmp_path, make_set):
    folder = make_set(tmp_path / "set", robots=(1, 2, 0, 3, 1))
    assert names(folder, "single") == "024"
    assert names(folder, "several") == "123"
    assert names(folder, "all") == "01234"


def test_a_phase_without_robots_is_refused(tmp_path, make_set):
    folder = make_set(tmp_path / "set", robots=(1, 1, 0))
    with pytest.raises(ConfigError, match=r"none of the 3 training images shows several robots"):
        names(folder, "several")


def test_plans():
    assert plan_phases((3, 2), one_phase=False) == (Phase("single", 3), Phase("several", 2))
    assert plan_phases((3, 2), one_phase=True) == (Phase("all", 5),)
    assert plan_phases((4,), one_phase=True) == (Phase("all", 4),)
    assert timed_phase(0.5) == (Phase("all", 0, 0.5),)
    with pytest.raises(ConfigError, match="two phases"):
        plan_phases((4,), one_phase=False)
    with pytest.raises(ConfigError, match="within 1 to"):
        plan_phases((4, 0), one_phase=False)
