# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects jumps of the GNSS position: it is used again once back, or stable elsewhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GnssJumpTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    jump_m: float = 10.0
    """Greatest distance of a position from the predicted one, at once, m. Judged."""
    jump_mps: float = 10.0
    """Growth of that distance with the time since the last fix, m/s. Judged."""
    steps_s: float = 5.0
    """Time over which the steps of a receiver tell how large they usually are, s. Judged."""
    first_step_m: float = 2.0
    """Usual step before the first, m. Judged."""
    odd_steps: float = 5.0
    """A step stands out if it is so many times as large as usual: beyond what is normal. Judged."""
    gust_mps2: float = 10.0
    """Acceleration of a drone, m/s²: that of gravity, at a bank of 45 deg."""
    stated_sigmas: float = 3.0
    """A jump matters if it is larger than so many stated sigmas of the receiver's offset: published
    covariances contain a smaller one. Judged."""
    home_share: float = 0.5
    """A position is back if it is nearer to where it was than to where it jumped to."""
    settle_s: float = 3.0
    """Time after which a position that has jumped is accepted, s. Judged."""


TUNING = GnssJumpTuning()


def nobody() -> bool:
    """Return that no robot tells of a jump."""
    return False


class GnssJumpDetector:
    """Tests each image's GNSS position.

    Attributes:
        offset: (3,) displacement since the jump, m; 0 without one.
        began: whether with the last image a jump began of which robots have not told.
        returned: whether the position returned with the last image, after a jump had been accepted.
    """

    def __init__(self, log: Events) -> None:
        self._log = log
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._usual_squared = TUNING.first_step_m**2
        self._end()

    def _end(self) -> None:
        """Forget all jumps."""
        self.offset = np.zeros(3)
        self.began = self.returned = False
        self._believed: Array = np.zeros(3)
        self._since_s = 0.0

    @property
    def believed(self) -> Array:
        """(2,) sum of the accepted jumps, m."""
        return self._believed[:2]

    def _is_odd(self, length: float, passed: float) -> bool:
        """Return whether a step is larger than steps are."""
        gust = 0.5 * TUNING.gust_mps2 * passed**2
        return length > TUNING.odd_steps * math.sqrt(self._usual_squared) + gust

    def update(
        self,
        position: Array,
        expected: Array | None,
        passed: float,
        stated_m: float = math.inf,
        robots_tell: Callable[[], bool] = nobody,
    ) -> tuple[bool, Array | None]:
        """Return whether a position can be used, and a newly accepted jump (3,), or None.

        Args:
            position: (3,) measured, m.
            expected: (3,) predicted, without the offset; None where it cannot be predicted.
            passed: time since the image before, s.
            stated_m: one sigma of the receiver's offset, m.
            robots_tell: returns whether robots tell that it has jumped: then they tell where they
                are as well, and it is believed at once. It is only called where a position stands
                out by less than what no drone flies.
        """
        self.began = self.returned = False
        if expected is not None:
            step = position - self.offset - expected
            step[2] = 0.0
            length, farthest = _length(step), _farthest(passed)
            matters = TUNING.stated_sigmas * stated_m < length <= farthest
            jumped = matters and self._is_odd(length, passed) and robots_tell()
            if jumped or length > farthest or self._returns(step, passed):
                told = jumped and not self.offset.any()
                self._jumped(step, length, passed, told)
                if not self._is_home():
                    return (True, self._believe()) if told else (False, None)
                jump = self.offset
                self._end()
                self.returned = True
                return True, jump
            share = 1.0 - math.exp(-passed / TUNING.steps_s)
            self._usual_squared += share * (length**2 - self._usual_squared)
        if not self.offset.any():
            return True, None
        self._since_s += passed
        if self._since_s < TUNING.settle_s:
            return False, None
        return True, self._believe()

    def _believe(self) -> Array:
        """Go on from where positions have jumped to; return by how much, (3,) m."""
        jump = self.offset
        believed = self._believed + jump
        self._log.add(
            f"The drone's position stays {_length(jump):.0f} m from where "
            "it was before it jumped; robots may be wrong by as much, as their covariances state."
        )
        self._end()
        self._believed = believed
        return jump

    def _returns(self, step: Array, passed: float) -> bool:
        """Return whether a step goes back to where positions were before they jumped."""
        away = self._believed + self.offset
        return self._is_odd(_length(step), passed) and _is_back(away + step, away)

    def _is_home(self) -> bool:
        """Return whether positions are back where they were before jumps that were believed."""
        return bool(self.offset.any()) and _is_back(self._believed + self.offset, self._believed)

    def _jumped(self, step: Array, length: float, passed: float, told: bool) -> None:
        self.began = not self.offset.any() and not self._believed.any()
        before, self.offset = self.offset, self.offset + step
        self._since_s = 0.0
        if _is_back(self.offset, before):
            self._log.add("The drone's position is back where it was before it jumped.")
            self.offset = np.zeros(3)
            return
        self._log.counts["position_jumps"] += 1
        self._log.add(
            f"The drone's position jumped by {length:.0f} m "
            f"within {passed:.2g} s{'.' if told else ': boxes are not used until it settles.'}"
        )


def _length(step: Array) -> float:
    """Return how far a step (3,) leads in the plane, m."""
    return math.hypot(float(step[0]), float(step[1]))


def _farthest(passed: float) -> float:
    """Return how far from where it is expected a drone can fly within a time, m."""
    return TUNING.jump_m + TUNING.jump_mps * passed


def _is_back(now: Array, before: Array) -> bool:
    """Return whether positions that were (3,) `before` off are right again, now that they are."""
    return _length(now) < min(TUNING.jump_m, TUNING.home_share * _length(before))
