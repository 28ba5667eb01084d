# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots' names: `<class>_<n>` in order of confirmation, or a name bound to a start.

Names are topics, so a class name is reduced to what ROS 2 allows in one. A name stands for one
robot for as long as the program runs, and over a restart where a state file keeps it.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, field


def class_token(class_id: str) -> str:
    """Return a class name reduced to [a-z][a-z0-9_]*, with no double underscore (a ROS 2 rule)."""
    plain = unicodedata.normalize("NFKD", class_id).encode("ascii", "ignore").decode().lower()
    token = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")
    if not token:
        return "robot"
    return token if token[0].isalpha() else f"robot_{token}"


@dataclass
class LabelRegistry:
    """Gives out names, each once.

    Args:
        bound: names that belong to a start and are never given by number.
        numbers: last number given, by reduced class name.
        taken: names in use or used up.
    """

    bound: frozenset[str] = frozenset()
    numbers: dict[str, int] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)

    def next(self, class_id: str) -> str:
        """Return the next free `<class>_<n>` and take it."""
        token = class_token(class_id)
        number = self.numbers.get(token, 0) + 1
        while (name := f"{token}_{number}") in self.taken or name in self.bound:
            number += 1
        self.numbers[token] = number
        self.taken.add(name)
        return name

    def reserve(self, name: str) -> None:
        """Mark a name as given."""
        self.taken.add(name)

    def free_bound(self) -> Iterable[str]:
        """Return the bound names that no robot has, sorted."""
        return sorted(self.bound - self.taken)

    def release(self, names: Iterable[str]) -> None:
        """Let those of some names that are bound be taken anew, at their starts, too."""
        self.taken -= self.bound.intersection(names)

    def release_bound(self) -> None:
        """Let bound names be taken anew: after the clock went backward all tracks are gone."""
        self.taken -= self.bound
