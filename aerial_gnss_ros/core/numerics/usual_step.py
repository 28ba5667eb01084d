# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The usual size of a measurement's steps, beside which a jump is conspicuous."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class UsualStepTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    usual_memory_s: float = 5.0
    """Time over which the usual step is determined, s. Judged."""
    odd_ratio: float = 5.0
    """Ratio to the usual step above which a step is conspicuous. Judged."""


TUNING = UsualStepTuning()


class UsualStep:
    """Root mean square of recent steps.

    Args:
        first: taken for usual before the first one; counts as one step.
    """

    def __init__(self, first: float) -> None:
        self._squared, self._weight = first**2, 1.0

    def is_odd(self, step: float, allowed: float) -> bool:
        """Return whether a step is conspicuous; `allowed`: what the drone's motion explains."""
        return step > TUNING.odd_ratio * math.sqrt(self._squared) + allowed

    def update(self, step: float, seconds: float) -> None:
        """Take in a step, some seconds after the previous one."""
        self._weight = 1.0 + math.exp(-seconds / TUNING.usual_memory_s) * self._weight
        self._squared += (step**2 - self._squared) / self._weight
