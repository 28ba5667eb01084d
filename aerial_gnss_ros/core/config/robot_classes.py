# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a class of robots, `classes.<name>.<key>`; default: the global ones."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.core.config.schema import Leaf, build, key, leaves
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import cut, shown

NAN = float("nan")
GROUP = "classes"


@dataclass(frozen=True)
class RobotClass:
    """How robots of a class move and dive, and how long they are."""

    max_speed: float = key(
        NAN,
        "Greatest speed over ground of a robot of this class; NaN: tracks.max_speed, which lists "
        "what follows from it.",
        unit="m/s",
        low=0.01,
        high=50.0,
        optional=True,
        dynamic=True,
    )
    acceleration: float = key(
        NAN,
        "Random-walk rate of its velocity; NaN: noise.robot_acceleration. Larger follows turns "
        "faster and smooths less; 0 for objects that drift without turning.",
        unit="m/s^1.5",
        low=0.0,
        high=100.0,
        optional=True,
        dynamic=True,
    )
    coast_s: float = key(
        NAN,
        "A confirmed robot of this class that is not detected is lost after this time; NaN: "
        "tracks.coast_s. Set a little more than its longest dive.",
        unit="s",
        low=0.0,
        high=3600.0,
        optional=True,
        dynamic=True,
    )
    length_m: tuple[float, ...] = key(
        (),
        "Shortest and longest length of a robot of this class, such as [0.4, 0.9]. Boxes that by "
        "their distance are longer or shorter, beyond what foam, pose and noise explain, are "
        "refused as wrong_size; tracks that are so in the mean are not confirmed. Empty: any.",
        unit="m",
        low=0.01,
        high=1000.0,
        dynamic=True,
    )


def leaf_of(name: str) -> Leaf | None:
    """Return the parameter of a dotted name such as `classes.aqua.max_speed`; None if none is."""
    parts = name.split(".")
    if len(parts) != 3 or parts[0] != GROUP:
        return None
    known = leaves(RobotClass, f"{GROUP}.{parts[1]}.")
    return next((leaf for leaf in known if leaf.name == name), None)


def robot_classes(
    flat: Mapping[str, Any], known: tuple[str, ...]
) -> tuple[tuple[str, RobotClass], ...]:
    """Return the parameters by class, ordered by name.

    Args:
        flat: values by dotted name, all of this group.
        known: names that `detections.classes` lets in; empty: any.

    Raises:
        ConfigError: an unknown class or key, a wrong type, or a value out of range.
    """
    names: dict[str, dict[str, Any]] = {}
    for dotted, value in flat.items():
        parts = dotted.split(".")
        if len(parts) != 3 or not parts[1]:
            keys = ", ".join(leaf.name for leaf in leaves(RobotClass))
            raise ConfigError(f"{cut(dotted)} is not a parameter; {GROUP}.<name> has {keys}.")
        names.setdefault(parts[1], {})[dotted] = value
    for name in names:
        if known and name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
            remedy = f"did you mean {GROUP}.{cut(near[0])}?" if near else "add it there."
            raise ConfigError(
                f"{GROUP}.{cut(name)}: {shown(name)} is not in detections.classes "
                f"({', '.join(map(cut, known))}); {remedy}"
            )
    return tuple((name, _robot_class(name, values)) for name, values in sorted(names.items()))


def _robot_class(name: str, values: Mapping[str, Any]) -> RobotClass:
    built = build(RobotClass, values, f"{GROUP}.{name}.")
    length = built.length_m
    if length and (len(length) != 2 or length[0] > length[1]):
        raise ConfigError(
            f"{GROUP}.{cut(name)}.length_m must be the shortest and the longest length, such as "
            f"[0.4, 0.9], not {shown(list(length))}."
        )
    return built
