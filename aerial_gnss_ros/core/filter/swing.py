# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much moored robots swing, or for how long errors of their boxes last.

Innovations of both add up where white noise would not: the mean square of sums of them over
`TUNING.sum_s` is larger than that of noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state_arrays import Indices

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SwingTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    sum_s: float = 1.0
    """Time constant over which innovations of a moored robot add up, s. Judged."""
    strained: float = 1.25
    """Mean of their normalised squares, halved, above which the swing is larger. Judged."""
    slack: float = 0.9
    """Below which it is smaller. Judged."""
    strain_s: float = 2.0
    """Time over which that mean is taken, anew after each change, s. Judged."""
    larger: float = 1.6
    """By what factor the swing's variance then changes. Judged."""
    least_sway_m: float = 0.01
    """Least swing, one sigma, m. Judged."""
    largest_sway_m: float = 0.3
    """Largest swing, one sigma, m. Judged."""


TUNING = SwingTuning()

_POWERS = np.array([1.0, 1.0, 2.0])


class Swing:
    """Of the n robots of a law.

    Args:
        count: n.

    Attributes:
        sums: (n, 3) of each robot's innovations (2), and the variance of that sum.
    """

    def __init__(self, count: int) -> None:
        self.sums: Array = np.zeros((count, 3))
        self._strain: Array = np.zeros(2)

    def keep(self, kept: NDArray[np.bool_], more: int) -> None:
        """Forget robots that are not kept (n,), and add some of which nothing is known."""
        self.sums = np.concatenate([self.sums[kept], np.zeros((more, 3))])

    def begin(self, slot: int) -> None:
        """Forget the innovations of a robot."""
        self.sums[slot] = 0.0

    def predict(self, seconds: float) -> None:
        """Move on in time."""
        self.sums *= math.exp(-seconds / TUNING.sum_s) ** _POWERS

    def update(self, slots: Indices, normalised: Array, seconds: float) -> None:
        """Take in an image.

        Args:
            slots: (m,) moored robots.
            normalised: (m, 2) their innovations.
            seconds: time since the image before, s.
        """
        sums = self.sums[slots]
        sums[:, :2] += normalised
        sums[:, 2] += 1.0
        self.sums[slots] = sums
        each = (sums[:, :2] ** 2).sum(axis=1) / sums[:, 2]
        self._strain += seconds * np.array([0.5 * each.sum(), len(slots)])

    def adapted(self, variance: float, count: int) -> float:
        """Return the variance of the swing, m², as boxes tell it.

        Args:
            variance: the present one, m².
            count: number of moored robots.
        """
        squares, weight = self._strain.tolist()
        if weight < TUNING.strain_s * count:
            return variance
        self._strain[:] = 0.0
        if squares > TUNING.strained * weight:
            return min(variance * TUNING.larger, TUNING.largest_sway_m**2)
        if squares < TUNING.slack * weight:
            return max(variance / TUNING.larger, TUNING.least_sway_m**2)
        return variance
