# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS arguments of the process: rclpy gives merged values, not the files they come from."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from aerial_gnss_ros.core.values.errors import ConfigError

_parameter_files: list[Path] = []


def remember(arguments: Sequence[str]) -> None:
    """Keep the parameter files among the arguments that ROS is initialised with."""
    _parameter_files[:] = [Path(b) for a, b in pairwise(arguments) if a == "--params-file"]


def parameter_files() -> list[Path]:
    """Return the files given with `--params-file`."""
    return list(_parameter_files)


def refuse_one_name_for_both(arguments: Sequence[str]) -> None:
    """Check the remappings of processes that run both nodes.

    Raises:
        ConfigError: a remapping gives both nodes the same name.
    """
    for flag, rule in pairwise(arguments):
        if flag in ("-r", "--remap") and rule.startswith(("__node:=", "__name:=")):
            name = rule.split(":=", 1)[1]
            raise ConfigError(
                f"{flag} {rule} gives detector and estimator the same name; rename one of them: "
                f"{flag} detector:__node:={name}, or run it alone with --node."
            )
