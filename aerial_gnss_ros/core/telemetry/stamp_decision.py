# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is decided of stamps: of one, and of several that are far off."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(str, Enum):
    """What a stamp is."""

    GOES_ON = "goes on"
    RETURNS = "returns"
    """It goes on after stamps far off, which are wrong."""
    FAR_OFF = "far off"
    ELSEWHERE = "elsewhere"
    """It is far off, and not where the stamps before it were: those are wrong."""


@dataclass(frozen=True)
class Decision:
    """What far-off stamps turned out to be.

    Attributes:
        anew: time began anew; else only the clocks of `moved` came right.
        moved: inputs whose rivals are believed from now on.
        kept: inputs whose lines are right as they are, although time began anew.
        by_ns: by how much time moved, ns.
        first_ns: stamp of the first image of the new time, ns.
        timed: whether this is beyond the time that has passed, by the node's clock.
        stepped: whether the node's clock moved along, so that it does not tell.
    """

    anew: bool
    moved: tuple[str, ...]
    kept: tuple[str, ...] = ()
    by_ns: int = 0
    first_ns: int = 0
    timed: bool = False
    stepped: bool = False

    def __str__(self) -> str:
        names = ", ".join(self.moved)
        if not self.anew:
            return f"The clock of {names} was set"
        way = "backward" if self.by_ns < 0 else "forward"
        return f"Time went {way} by {abs(self.by_ns) * 1e-9:.1f} s ({names})"
