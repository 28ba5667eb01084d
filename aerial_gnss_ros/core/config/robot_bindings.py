# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels bound to robots by their start positions."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import cut, shown


@dataclass(frozen=True)
class RobotBinding:
    """A label bound to the robot that is first confirmed near a start.

    Attributes:
        name: the robot's id in topics.
        class_id: class name that the detector gives it.
        latitude: of the start, rad.
        longitude: of the start, rad.
    """

    name: str
    class_id: str
    latitude: float
    longitude: float


def robot_bindings(flat: Mapping[str, Any]) -> tuple[RobotBinding, ...]:
    """Return the bindings of the parameters `robots.<name>.class` and `.start`, by name.

    Args:
        flat: values by dotted name without `robots`.

    Raises:
        ConfigError: a name that is invalid in topics, an unknown key, or an invalid start.
    """
    names: dict[str, dict[str, Any]] = {}
    for dotted, value in flat.items():
        parts = dotted.split(".")
        if len(parts) != 3 or parts[2] not in ("class", "start"):
            raise ConfigError(
                f"{cut(dotted)} is not a parameter; robots.<name> has class and start."
            )
        names.setdefault(parts[1], {})[parts[2]] = value
    return tuple(_binding(name, values) for name, values in sorted(names.items()))


def _binding(name: str, values: Mapping[str, Any]) -> RobotBinding:
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
        raise ConfigError(
            f"robots.{cut(name)} cannot be a topic name; use lower-case letters and digits "
            "with single _ between, and begin with a letter."
        )
    class_id, start = values.get("class"), values.get("start")
    if not isinstance(class_id, str) or not class_id:
        raise ConfigError(
            f"robots.{cut(name)}.class must be the name of a class, not {shown(class_id)}."
        )
    numbers = list(start) if isinstance(start, list | tuple) else []
    if len(numbers) != 2 or not all(
        isinstance(n, int | float) and not isinstance(n, bool) for n in numbers
    ):
        raise ConfigError(
            f"robots.{cut(name)}.start must be [latitude, longitude] in degrees, not "
            f"{shown(start)}."
        )
    latitude, longitude = float(numbers[0]), float(numbers[1])
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        raise ConfigError(f"robots.{cut(name)}.start {shown(numbers)} is not on Earth.")
    return RobotBinding(name, class_id, math.radians(latitude), math.radians(longitude))
