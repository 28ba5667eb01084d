# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects jumps of the GNSS position: it is used again once back, or stable elsewhere."""

from __future__ import annotations

import math
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
    settle_s: float = 3.0
    """Time after which a position that has jumped is accepted, s. Judged."""


TUNING = GnssJumpTuning()


class GnssJumpDetector:
    """Tests each image's GNSS position.

    Attributes:
        offset: (3,) displacement since the jump, m; 0 without one.
        began: whether a jump began with the last image.
        returned: whether the position returned with the last image, after a jump had been accepted.
    """

    def __init__(self, log: Events) -> None:
        self._log = log
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.offset = np.zeros(3)
        self.began = self.returned = False
        self._believed: Array = np.zeros(3)
        self._since_s = 0.0

    @property
    def believed(self) -> Array:
        """(2,) sum of the accepted jumps, m."""
        return self._believed[:2]

    def update(
        self, position: Array, expected: Array | None, passed: float
    ) -> tuple[bool, Array | None]:
        """Return whether a position can be used, and a newly accepted jump (3,), or None.

        Args:
            position: (3,) measured, m.
            expected: (3,) predicted, without the offset; None where it cannot be predicted.
            passed: time since the image before, s.
        """
        self.began = self.returned = False
        if expected is not None:
            step = position - self.offset - expected
            step[2] = 0.0
            length = math.hypot(step[0], step[1])
            if length > TUNING.jump_m + TUNING.jump_mps * passed:
                self._jumped(step, length, passed)
                if not self._is_home():
                    return False, None
                jump = self.offset
                self.reset()
                self.returned = True
                return True, jump
        if not self.offset.any():
            return True, None
        self._since_s += passed
        if self._since_s < TUNING.settle_s:
            return False, None
        jump = self.offset
        believed = self._believed + jump
        self._log.add(
            f"The drone's position stays {math.hypot(jump[0], jump[1]):.0f} m from where "
            "it was before it jumped; robots may be wrong by as much, as their covariances state."
        )
        self.reset()
        self._believed = believed
        return True, jump

    def _is_home(self) -> bool:
        """Return whether positions are back where they were before accepted jumps."""
        if not self._believed.any() or not self.offset.any():
            return False
        east, north, _ = (self._believed + self.offset).tolist()
        return math.hypot(east, north) < TUNING.jump_m

    def _jumped(self, step: Array, length: float, passed: float) -> None:
        self.began = not self.offset.any() and not self._believed.any()
        self.offset = self.offset + step
        self._since_s = 0.0
        if math.hypot(self.offset[0], self.offset[1]) < TUNING.jump_m:
            self._log.add("The drone's position is back where it was before it jumped.")
            self.offset = np.zeros(3)
            return
        self._log.counts["position_jumps"] += 1
        self._log.add(
            f"The drone's position jumped by {length:.0f} m "
            f"within {passed:.2g} s: boxes are not used until it settles."
        )
