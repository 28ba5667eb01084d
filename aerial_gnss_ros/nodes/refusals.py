# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Refused images: counts by reason, and the error of the last one."""

from __future__ import annotations

from collections import Counter

from aerial_gnss_ros.nodes.arrivals import SECOND_NS

RECENT_S = 10.0
"""Duration of the warning after a refused image: a single damaged frame must not warn all day."""


class Refusals:
    """Counts refusals.

    Attributes:
        counts: by reason, since the start.
    """

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._last, self._last_ns = "", 0

    @property
    def total(self) -> int:
        """Total number of refused images."""
        return sum(self.counts.values())

    def add(self, reason: str, sentence: str, now_ns: int) -> None:
        """Count one.

        Args:
            reason: short identifier of the reason.
            sentence: the error of this image.
            now_ns: steady time.
        """
        self.counts[reason] += 1
        self._last, self._last_ns = sentence.rstrip("."), now_ns

    def recent(self, now_ns: int) -> str:
        """Return the error of the last refused image if less than `RECENT_S` ago."""
        recent = self.total and now_ns - self._last_ns < RECENT_S * SECOND_NS
        return self._last if recent else ""

    def values(self) -> dict[str, int]:
        """Return the counts as /diagnostics shows them."""
        return {f"refused_{reason}": count for reason, count in sorted(self.counts.items())}
