# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Objects of known position in view, `references.<name>.<key>`."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

from aerial_gnss_ros.core.config.schema import Leaf, build, key, leaves
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import cut, shown

NAN = float("nan")
GROUP = "references"


@dataclass(frozen=True)
class Reference:
    """One object of known position: give `position` or `topic`, not both."""

    class_id: str = key(
        "",
        "Class name that the detector gives it. Best a class that only references have: else its "
        "position must distinguish it from robots, which takes a better receiver.",
        dynamic=True,
    )
    position: tuple[float, ...] = key(
        (),
        "Latitude and longitude of what stays, such as a beacon, or of the middle of its watch "
        "circle. A wrong one is found only where it contradicts the receiver or other references.",
        unit="deg",
        low=-180.0,
        high=180.0,
        dynamic=True,
    )
    topic: str = key(
        "",
        "sensor_msgs/NavSatFix of what moves and has a receiver of its own, relative to the "
        "namespace.",
        dynamic=True,
    )
    sigma_m: float = key(
        NAN,
        "One sigma of its position, each axis: how well it was surveyed, or its receiver measures "
        "where the message has no covariance. It does not average out.",
        unit="m",
        low=0.0,
        high=100.0,
        optional=True,
        dynamic=True,
    )
    radius_m: float = key(
        0.0,
        "Radius of the watch circle of what is moored; 0: it does not swing.",
        unit="m",
        low=0.0,
        high=1000.0,
        dynamic=True,
    )
    height_m: float = key(
        0.0,
        "How far above the water the middle of its box is. 1 m ignored is 1 m wrong at 45 deg.",
        unit="m",
        low=0.0,
        high=50.0,
        dynamic=True,
    )
    name: str = ""

    @property
    def variance(self) -> float:
        """Of its position, each axis, m²; NaN: the messages' own. A disc has a quarter of r²."""
        return self.sigma_m**2 + 0.25 * self.radius_m**2


REFERENCE_KEYS = {
    "class" if leaf.name == "class_id" else leaf.name: leaf for leaf in leaves(Reference)
}
"""Parameters of a reference by their keys; Python keeps the name of one for itself."""


def reference_leaf_of(name: str) -> Leaf | None:
    """Return the parameter of a dotted name such as `references.pier.sigma_m`; None if none is."""
    parts = name.split(".")
    if len(parts) != 3 or parts[0] != GROUP or parts[2] not in REFERENCE_KEYS:
        return None
    return replace(REFERENCE_KEYS[parts[2]], name=name)


def references(flat: Mapping[str, Any], classes: tuple[str, ...]) -> tuple[Reference, ...]:
    """Return the references of the parameters `references.<name>.<key>`, by name.

    Args:
        flat: values by dotted name, all of this group.
        classes: names that `detections.classes` lets in; empty: any.

    Raises:
        ConfigError: an unknown key, a wrong value, or references that contradict one another.
    """
    names: dict[str, dict[str, Any]] = {}
    keys = ", ".join(REFERENCE_KEYS)
    for dotted, value in flat.items():
        parts = dotted.split(".")
        if len(parts) != 3 or parts[2] not in REFERENCE_KEYS:
            raise ConfigError(f"{cut(dotted)} is not a parameter; {GROUP}.<name> has {keys}.")
        names.setdefault(parts[1], {})[REFERENCE_KEYS[parts[2]].name] = value
    found = tuple(_reference(name, values, classes) for name, values in sorted(names.items()))
    for one, other in combinations(found, 2):
        _check_pair(one, other)
    return found


def _reference(name: str, values: Mapping[str, Any], classes: tuple[str, ...]) -> Reference:
    where = f"{GROUP}.{cut(name)}"
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
        raise ConfigError(
            f"{where}: use lower-case letters and digits with single _ between, and begin with a "
            "letter."
        )
    prefix = f"{GROUP}.{name}."
    try:
        made = build(
            Reference, {f"{prefix}{key_}": value for key_, value in values.items()}, prefix
        )
    except ConfigError as error:
        raise ConfigError(str(error).replace(f"{prefix}class_id", f"{prefix}class")) from error
    if not made.class_id:
        raise ConfigError(f"{where}.class must be the name of a class: nothing is bound to it.")
    if classes and made.class_id not in classes:
        raise ConfigError(
            f"{where}.class is {shown(made.class_id)}, which detections.classes "
            f"({', '.join(map(cut, classes))}) refuses; give one of these, or add it there."
        )
    if bool(made.position) == bool(made.topic):
        both = "both" if made.topic else "neither"
        raise ConfigError(f"{where} must have a position or a topic, not {both}.")
    if made.sigma_m == 0.0:
        raise ConfigError(
            f"{where}.sigma_m is 0, but no position is known exactly; give how well it is known."
        )
    if made.position:
        _check_position(where, made)
    elif made.radius_m:
        raise ConfigError(f"{where}.radius_m is for what stays; what has a topic has none.")
    return replace(made, name=name)


def _check_position(where: str, made: Reference) -> None:
    if len(made.position) != 2 or abs(made.position[0]) > 90.0:
        raise ConfigError(
            f"{where}.position must be [latitude, longitude] in degrees, not "
            f"{shown(list(made.position))}."
        )
    if made.position == (0.0, 0.0):
        raise ConfigError(
            f"{where}.position is [0, 0], what receivers send without a fix; give its own."
        )
    if math.isnan(made.sigma_m):
        raise ConfigError(f"{where}.sigma_m must say how well its position is known, in m.")


def _check_pair(one: Reference, other: Reference) -> None:
    """Refuse two references that cannot both be."""
    both = f"{GROUP}.{cut(one.name)} and {GROUP}.{cut(other.name)}"
    if one.topic and one.topic == other.topic:
        raise ConfigError(f"{both} have one topic, {cut(one.topic)}; each needs its own.")
    if not (one.position and other.position) or one.class_id != other.class_id:
        return
    places = map(math.radians, (*one.position, *other.position))
    if geodesic_inverse(*places)[0] < 0.1:
        raise ConfigError(f"{both} are of one class at one place; remove one of them.")
