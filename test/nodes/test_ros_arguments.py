# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the arguments for ROS say: parameter files, and one name for two nodes."""

from __future__ import annotations

from pathlib import Path

import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.nodes.ros_arguments import (
    parameter_files,
    refuse_one_name_for_both,
    remember,
)


def test_the_files_of_the_last_arguments_are_kept():
    remember(["--ros-args", "--params-file", "a.yaml", "-p", "x:=1", "--params-file", "b.yaml"])
    found = parameter_files()
    assert found == [Path("a.yaml"), Path("b.yaml")]
    found.clear()
    assert len(parameter_files()) == 2
    remember([])
    assert parameter_files() == []


@pytest.mark.parametrize("flag", ["-r", "--remap"])
@pytest.mark.parametrize("rule", ["__node:=boat", "__name:=boat"])
def test_one_name_for_both_nodes_is_refused(flag, rule):
    with pytest.raises(ConfigError, match="detector:__node:=boat"):
        refuse_one_name_for_both(["--ros-args", flag, rule])


@pytest.mark.parametrize("rule", ["detector:__node:=boat", "__ns:=/boat", "image:=/camera"])
def test_other_rules_are_let_pass(rule):
    refuse_one_name_for_both(["--ros-args", "-r", rule, "-p", "__node:=boat"])
