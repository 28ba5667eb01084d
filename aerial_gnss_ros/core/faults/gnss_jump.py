# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects jumps of the GNSS position: it is used again once back, or stable elsewhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.models.usual_step import UsualStep
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GnssJumpTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    jump_m: float = 10.0
    """Greatest distance of a position from the predicted one, at once, m. Judged."""
    jump_mps: float = 10.0
    """Growth of that distance with the time since the last fix, m/s. Judged."""
    first_step_m: float = 2.0
    """Usual step before the first, m. Judged."""
    gust_mps2: float = 10.0
    """Acceleration of a drone, m/s²: that of gravity, at a bank of 45 deg."""
    home_share: float = 0.5
    """Share of the jump within which a position counts as back: closer to the old than to the new
    position."""
    settle_s: float = 3.0
    """Time after which a position that has jumped is accepted, s. Judged."""


TUNING = GnssJumpTuning()


def nobody() -> bool:
    """Return that robots give no evidence of a jump."""
    return False


class GnssJumpDetector:
    """Tests each image's GNSS position.

    Attributes:
        offset: (3,) displacement since the jump, m; 0 without one.
        began: whether a jump without evidence from robots began with the last image.
        returned: whether the position returned with the last image, after a jump had been accepted.
    """

    def __init__(self, log: Events) -> None:
        self._log = log
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._usual = UsualStep(TUNING.first_step_m)
        self._end()

    def _end(self) -> None:
        """Clear all jumps."""
        self.offset = np.zeros(3)
        self.began = self.returned = False
        self._believed: Array = np.zeros(3)
        self._since_s = 0.0

    @property
    def believed(self) -> Array:
        """(2,) sum of the accepted jumps, m."""
        return self._believed[:2]

    def _is_odd(self, length: float, passed: float) -> bool:
        """Return whether a step is conspicuous."""
        gust = 0.5 * TUNING.gust_mps2 * passed**2
        return self._usual.is_odd(length, gust)

    def update(
        self,
        position: Array,
        expected: Array | None,
        passed: float,
        stated_m: float = math.inf,
        robots_tell: Callable[[], bool] = nobody,
        velocity_known: bool = True,
    ) -> tuple[bool, Array | None]:
        """Return whether a position can be used, and a newly accepted jump (3,), or None.

        Args:
            position: (3,) measured, m.
            expected: (3,) predicted, without the offset; None without a prediction.
            passed: time since the previous image, s.
            stated_m: one sigma of the receiver's offset, m.
            robots_tell: tests by robots whether it has jumped; if so, it is accepted at once. It is
                only called for a conspicuous step that a drone could have flown.
            velocity_known: whether the prediction has the drone's velocity. After a gap it has
                not, and a step that a drone can fly is no jump.
        """
        self.began = self.returned = False
        if expected is not None:
            step = position - self.offset - expected
            step[2] = 0.0
            length, farthest = _length(step), _farthest(passed)
            matters = velocity_known and SURE_SIGMAS * stated_m < length <= farthest
            jumped = matters and self._is_odd(length, passed) and robots_tell()
            if jumped or length > farthest or (velocity_known and self._returns(step, passed)):
                told = jumped and not self.offset.any()
                self._jumped(step, length, passed, told)
                if not self._is_home():
                    return (True, self._believe()) if told else (False, None)
                jump = self.offset
                self._end()
                self.returned = True
                return True, jump
            if velocity_known:
                self._usual.update(length, passed)
        if not any(self.offset.tolist()):
            return True, None
        self._since_s += passed
        if self._since_s < TUNING.settle_s:
            return False, None
        return True, self._believe()

    def _believe(self) -> Array:
        """Accept the position after a jump; return the jump (3,), m."""
        jump = self.offset
        believed = self._believed + jump
        self._log.add(
            f"The drone's position stays {_length(jump):.1f} m from that before its jump; robots "
            "may be wrong by as much, as their covariances state."
        )
        self._end()
        self._believed = believed
        return jump

    def _returns(self, step: Array, passed: float) -> bool:
        """Return whether a step returns to the position before the jump."""
        away = self._believed + self.offset
        return self._is_odd(_length(step), passed) and _is_back(away + step, away)

    def _is_home(self) -> bool:
        """Return whether positions are back where they were before the accepted jumps."""
        return bool(self.offset.any()) and _is_back(self._believed + self.offset, self._believed)

    def _jumped(self, step: Array, length: float, passed: float, told: bool) -> None:
        self.began = not self.offset.any() and not self._believed.any()
        before, self.offset = self.offset, self.offset + step
        self._since_s = 0.0
        if _is_back(self.offset, before):
            self._log.add("The drone's position is back at that before its jump.")
            self.offset = np.zeros(3)
            return
        self._log.counts["position_jumps"] += 1
        self._log.add(
            f"The drone's position jumped by {length:.1f} m "
            f"within {passed:.2g} s{'.' if told else ': boxes are not used until it settles.'}"
        )


def _length(step: Array) -> float:
    """Return the horizontal length of a step (3,), m."""
    return math.hypot(float(step[0]), float(step[1]))


def _farthest(passed: float) -> float:
    """Return how far a drone can fly from its predicted position within a time, m."""
    return TUNING.jump_m + TUNING.jump_mps * passed


def _is_back(now: Array, before: Array) -> bool:
    """Return whether positions that were off by `before` (3,) are right again."""
    return _length(now) < min(TUNING.jump_m, TUNING.home_share * _length(before))
