# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Format of robots' labels: `<class>_<n>` in order of confirmation, or a bound name.

A label is part of topic names, so the class is reduced to characters that ROS 2 allows there. It
stands for one robot while the program runs, and beyond a restart if a state file is kept.
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
    """Issues each label once.

    Args:
        bound: labels bound to a start position, never issued by number.
        numbers: last number issued, by reduced class name.
        taken: labels issued so far.
    """

    bound: frozenset[str] = frozenset()
    numbers: dict[str, int] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)

    def next(self, class_id: str) -> str:
        """Issue the next free `<class>_<n>`."""
        token = class_token(class_id)
        number = self.numbers.get(token, 0) + 1
        while (name := f"{token}_{number}") in self.taken or name in self.bound:
            number += 1
        self.numbers[token] = number
        self.taken.add(name)
        return name

    def reserve(self, name: str) -> None:
        """Mark a label as issued."""
        self.taken.add(name)

    def free_bound(self) -> Iterable[str]:
        """Return the bound labels that no robot has, sorted."""
        return sorted(self.bound - self.taken)

    def release(self, names: Iterable[str]) -> None:
        """Make those of some labels that are bound available again."""
        self.taken -= self.bound.intersection(names)

    def release_bound(self) -> None:
        """Make all bound labels available: tracks ended when the clock went backward."""
        self.taken -= self.bound
