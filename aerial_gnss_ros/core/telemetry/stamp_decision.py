# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Decisions on stamps: on one, and on several outliers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(str, Enum):
    """Decision on a stamp."""

    GOES_ON = "goes on"
    RETURNS = "returns"
    """It continues after outliers, which are wrong."""
    FAR_OFF = "far off"
    ELSEWHERE = "elsewhere"
    """It is an outlier, unrelated to the outliers before it, which are wrong."""


@dataclass(frozen=True)
class Decision:
    """Decision on outlying stamps.

    Attributes:
        time_reset: whether time was reset; otherwise only the clocks of `moved` were set.
        moved: inputs whose rivals are trusted from now on.
        kept: inputs whose lines stay valid although time was reset.
        by_ns: step of time, ns.
        first_ns: stamp of the first image of the new time, ns.
        timed: whether `by_ns` excludes the elapsed time, by the node's clock.
        stepped: whether the node's clock stepped, too, so that it gives no elapsed time.
    """

    time_reset: bool
    moved: tuple[str, ...]
    kept: tuple[str, ...] = ()
    by_ns: int = 0
    first_ns: int = 0
    timed: bool = False
    stepped: bool = False

    def __str__(self) -> str:
        names = ", ".join(self.moved)
        if not self.time_reset:
            return f"The clock of {names} was set"
        way = "backward" if self.by_ns < 0 else "forward"
        return f"Time went {way} by {abs(self.by_ns) * 1e-9:.1f} s ({names})"
