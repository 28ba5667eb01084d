# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Places of the GNSS position, between which it jumps, and which of them is right.

A receiver whose errors change at once (it loses or regains corrections, or a satellite) has a few
places, each displaced from the others. Which one is right is unknown: each is as likely as the
share of time for which it has lasted, over the sigma that the receiver states. (Not its square:
receivers also jump with wrong corrections, of which they are as sure.) The likeliest is used: while
the receiver is elsewhere, its displacement is taken out, so a short jump displaces no robot. When
another place becomes the likelier one, robots move there with the drone.

When the receiver returns to the likeliest place, that is right, and the others are not: no error
recurs. A reference in view shows the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GnssJumpTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    jump_m: float = 10.0
    """Greatest step that a drone may have flown at once, m. Judged."""
    jump_mps: float = 10.0
    """Growth of that step with the time since the last image, m/s. Judged."""
    least_present: float = 0.125
    """Least probability of the place where the receiver is: it may have been wrong until now, for
    however long. Judged."""
    same_m: float = 1e-6
    """Distance below which two places are one, m: rounding."""
    places: int = 16
    """Number of places that are remembered. Judged."""


TUNING = GnssJumpTuning()


def nobody() -> bool:
    """Return that robots give no evidence of a jump."""
    return False


@dataclass(eq=False)
class Place:
    """One place of the position.

    Attributes:
        at: (3,) by how much it is displaced from the first one, m.
        weight: for how long the receiver was there, by the sigma that it stated, s/m.
        wrong: whether the receiver has come back from it.
    """

    at: Array
    weight: float = 0.0
    wrong: bool = False


class GnssJumpDetector:
    """Follows the GNSS position of images from place to place."""

    def __init__(self, log: Events) -> None:
        self._log = log
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._jumped: tuple[float, ...] | None = None
        self._places = [Place(np.zeros(3))]
        self._used = self._present = self._places[0]

    @property
    def offset(self) -> Array:
        """(3,) displacement of the receiver from the place that is used, m."""
        return self._present.at - self._used.at

    @property
    def believed(self) -> Array:
        """(2,) displacement of the place that is used from the first one, m."""
        return self._used.at[:2]

    @property
    def doubt(self) -> float:
        """Mean square of the displacement of the place that is used from the right one, m²."""
        used, found = self._used, 0.0
        for one in self._places:
            if one is not used and not one.wrong:
                share = one.weight / max(one.weight + used.weight, 1e-12)
                least = TUNING.least_present if one is self._present else 0.0
                found += max(share, least) * _length(one.at - used.at) ** 2
        return found

    def update(
        self,
        jumped: tuple[float, ...],
        passed: float,
        stated_m: float,
        robots_tell: Callable[[], bool] = nobody,
    ) -> Array | None:
        """Update with an image's position; return the step (3,) to another place, m, or None.

        Args:
            jumped: East and North by which the receiver has jumped so far (`telemetry.jumps`), m;
                empty: it has not.
            passed: time since the previous image, s.
            stated_m: one sigma of the receiver's offset, m.
            robots_tell: tests by robots whether it has jumped. It is only called for a step that a
                drone could have flown: one that robots do not tell of was flown.
        """
        step = _step(self._jumped, jumped)
        length, farthest = _length(step), TUNING.jump_m + TUNING.jump_mps * passed
        # Robots tell by copies of the tracks, which have not seen this step.
        told = SURE_SIGMAS * stated_m < length <= farthest and robots_tell()
        self._jumped = jumped
        if told or length > farthest:
            self._move(step)
        self._present.weight += max(passed, 0.0) / max(stated_m, TUNING.same_m)
        if self._present.weight <= self._used.weight:
            return None
        moved, self._used = self.offset, self._present
        self._log.add(
            f"The receiver's position after its jump of {_length(moved):.1f} m has lasted longer "
            "than the one before, or is surer, and is used now; robots may be wrong by as much, as "
            "their covariances state."
        )
        return moved

    def confirm(self) -> None:
        """Take in that something of known position shows the place that is used to be right."""
        for one in self._places:
            if one is not self._used:
                one.weight, one.wrong = -math.inf, True

    def _move(self, step: Array) -> None:
        """Take in that the receiver has jumped."""
        self._log.counts["position_jumps"] += 1
        there = self._present.at + step
        known = next((p for p in self._places if _length(p.at - there) < TUNING.same_m), None)
        self._present = known or Place(there)
        if known is None:
            self._places = [*self._places[-TUNING.places + 1 :], self._present]
            if self._used not in self._places:
                self._places[0] = self._used
        back = self._present is self._used
        if back:
            for one in self._places:
                one.wrong = one is not self._used
        self._log.add(
            f"The receiver's position jumped by {_length(step):.1f} m"
            + (" and is back." if back else ": it is corrected by that while it is new.")
        )


def _step(before: tuple[float, ...] | None, now: tuple[float, ...]) -> Array:
    """Return the (3,) way from one sum of jumps to another, m; 0 without the first."""
    if before is None or before == now:
        return np.zeros(3)
    return np.append(np.subtract(now or (0.0, 0.0), before or (0.0, 0.0)), 0.0)


def _length(step: Array) -> float:
    """Return the horizontal length of a step (3,), m."""
    return math.hypot(float(step[0]), float(step[1]))
