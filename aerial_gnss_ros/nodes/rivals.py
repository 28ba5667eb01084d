# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Other publishers of what only one node may publish. Knows no ROS."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

UNKNOWN = "a node of which nothing more is known yet"
"""Of a publisher whose node is not: the graph learns of both in any order."""

LOOKS = 2
"""So often in a row others must be there, a second apart: the graph changes in steps."""

FIRST_LOOKS, LEASE_LOOKS = 3, 25
"""Who is there already in the first looks may be what this node replaces: DDS forgets a process
that could not say goodbye only after 20 s. So others must then be there for longer."""


class Rivals:
    """Watches for others that do what a node does.

    Args:
        kind: of the node, such as estimator.

    Attributes:
        trouble: what is wrong, in a sentence; empty while the node is the only one.
    """

    def __init__(self, kind: str) -> None:
        self.trouble = ""
        self._kind = kind
        self._looks = self._seen = 0
        self._needed = LOOKS
        self._told = False

    def look(self, own: str, publishers: Mapping[str, Iterable[str]], nodes: Iterable[str]) -> str:
        """Take in who is there; return a sentence to log, the first time that others are.

        Args:
            own: the node's fully qualified name.
            publishers: topics that the node publishes, each with its publishers' node names.
            nodes: fully qualified names of all nodes.
        """
        shared = {topic: sorted(names) for topic, names in publishers.items()}
        shared = {topic: names for topic, names in shared.items() if len(names) > 1}
        others = sorted({name for names in shared.values() for name in names} - {own})
        twice = list(nodes).count(own) > 1
        self._looks += 1
        self._seen = self._seen + 1 if shared or twice else 0
        if self._seen == 1:
            self._needed = LEASE_LOOKS if self._looks <= FIRST_LOOKS else LOOKS
        if not self._seen or self._seen < self._needed:
            self.trouble, self._told = "", False
            return ""
        self.trouble = self._sentence(own, others, sorted(shared), twice)
        first, self._told = not self._told, True
        return self.trouble if first else ""

    def _sentence(self, own: str, others: list[str], topics: list[str], twice: bool) -> str:
        who = [f"another node named {own}"] if twice or not others else []
        what = f"publishes {topics[0]}, too" if topics else "runs"
        return (
            f"{' and '.join([*who, *others])} {what}: receivers get what both publish, mixed up. "
            f"Only one {self._kind} may run in a namespace: end the other, or give it one of its "
            "own."
        )
