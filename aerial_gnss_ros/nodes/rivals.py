# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects other publishers on topics that only one node may publish. Independent of ROS."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

UNKNOWN = "a node not yet identified"
"""Node of a publisher before the graph knows it: they are discovered in any order."""

LOOKS = 2
"""Consecutive looks, a second apart, in which a rival must be present: discovery is gradual."""

FIRST_LOOKS, LEASE_LOOKS = 3, 25
"""A rival present from the first looks may be the process that this node replaces: DDS drops a
killed process only after its lease of 20 s. Such a rival must be present for longer."""


class Rivals:
    """Watches for rivals of a node.

    Args:
        kind: of the node, such as estimator.

    Attributes:
        trouble: the fault in a sentence; empty without rivals.
    """

    def __init__(self, kind: str) -> None:
        self.trouble = ""
        self._kind = kind
        self._looks = self._seen = 0
        self._needed = LOOKS
        self._told = False

    def look(self, own: str, publishers: Mapping[str, Iterable[str]], nodes: Iterable[str]) -> str:
        """Update with the current graph; return a sentence to log when rivals first appear.

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
