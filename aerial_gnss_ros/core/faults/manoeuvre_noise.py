# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Adapts each robot's process noise to its manoeuvres, from the corrections of its velocity.

A robot that manoeuvres harder than `noise.robot_acceleration` makes the filter overconfident: its
turns are attributed to the camera's heading, height and tilt. From high up, boxes are too coarse
for that; from 7 m they are not. Single residuals are mostly box noise, but corrections of the
velocity show it: for a manoeuvring robot they are correlated over seconds, otherwise independent.

Under the stated model the corrections of `TUNING.correction_sum_s` seconds have a sum of known
covariance, in the long run that of the stated acceleration over this time. So the ratio of the
squared sum to its expectation is that of the actual to the stated spectral density (covariance
matching: Mehra 1972; here of velocities rather than residuals).

Until then too much was taken for errors of the platform, and these last. So the filter is told by
how much the robots' process noise was too small, and divides what it has learnt by that: if robots
tell equally much, the estimate's covariance was too small by the mean of theirs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ManoeuvreNoiseTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    correction_sum_s: float = 3.0
    """Time constant over which corrections are summed, s: about that of a turn. Judged."""
    turns_memory_s: float = 30.0
    """Time constant of the mean ratio, s. Judged."""
    strength_every_s: float = 0.5
    """Interval between updates of the strength, s: sums change no faster. Judged."""
    ratio_variance: float = 1.5
    """Variance of one ratio: 1 where both axes are known equally, 2 where only one is known. By the
    chi-square distribution."""
    largest_strength: float = 100.0
    """Upper bound of the strength: ten times the stated acceleration. Judged."""


TUNING = ManoeuvreNoiseTuning()


class ManoeuvreNoise:
    """Process noise of n robots.

    Attributes:
        strength: (n,) ratio of the actual to the stated spectral density of the acceleration.
    """

    def __init__(self) -> None:
        self.strength: Array = np.zeros(0)
        # Rows: sum of corrections east, north; its expected square; the acceleration's part of it;
        # the same since the last image; sum of ratios, of their weights; time since it was judged.
        self._sums: Array = np.zeros((8, 0))
        self._since = 0.0
        self._underestimated = 1.0

    def add(self, count: int) -> None:
        """Append robots."""
        self.strength = np.concatenate([self.strength, np.ones(count)])
        self._sums = np.concatenate([self._sums, np.zeros((8, count))], axis=1)

    def drop(self, kept: NDArray[np.bool_]) -> None:
        """Remove the robots that are not kept (n,)."""
        self.strength, self._sums = self.strength[kept], self._sums[:, kept]

    def forget(self) -> None:
        """Forget what was seen of the robots."""
        self.strength, self._sums = np.ones_like(self.strength), np.zeros_like(self._sums)

    def inherit(self, old: int, new: int) -> None:
        """Let robot `new` continue the statistics of `old`."""
        self.strength[new] = self.strength[old]
        self._sums[5:7, new] = self._sums[5:7, old]

    def copy(self, other: ManoeuvreNoise, slot: int) -> None:
        """Let the last robot continue the statistics of robot `slot` of another block."""
        self.strength[-1], self._sums[:, -1] = other.strength[slot], other._sums[:, slot]

    def take_underestimated(self) -> float:
        """Return by how much the robots' mean strength turned out too small, once; at least 1."""
        factor, self._underestimated = self._underestimated, 1.0
        return factor

    def predict(self, seconds: float, density: Array | float) -> None:
        """Advance in time.

        Args:
            seconds: length of the step, s.
            density: stated spectral density of each axis' acceleration, m²/s³.
        """
        if not (density.any() if isinstance(density, np.ndarray) else density):
            return
        fade = math.exp(-seconds / TUNING.correction_sum_s)
        self._sums[:2] *= fade
        self._sums[2:4] *= fade * fade
        self._sums[4] += 2.0 * density * seconds * self.strength
        self._sums[7] += seconds
        self._since += seconds

    def update(self, slots: Indices | slice, changes: Array, expected: Array) -> None:
        """Update with an image's velocity corrections.

        Args:
            slots: m robots.
            changes: (m, 2) corrections of their velocities, m/s.
            expected: (m,) their expected squares, m²/s².
        """
        sums = self._sums[:5, slots]
        # Initial corrections, by which a velocity becomes known at all, count less.
        usual = np.minimum(sums[4] / np.maximum(expected, 1e-12), 1.0)
        sums[:2] += usual * changes.T
        sums[2:4] += usual**2 * (expected, sums[4])
        sums[4] = 0.0
        self._sums[:5, slots] = sums
        if self._since >= TUNING.strength_every_s:
            self._since = 0.0
            self._judge(slots)

    def _judge(self, slots: Indices | slice) -> None:
        """Compare the sums with their expectation.

        What an image's robots have in common is the camera's and is subtracted.
        """
        sums = self._sums[:, slots]
        m = sums.shape[1]
        own = sums[:2]
        if m > 1:
            own = (own - own.mean(axis=1, keepdims=True)) * math.sqrt(m / (m - 1))
        whole = np.maximum(sums[2], 1e-12)
        ratio = (own[0] ** 2 + own[1] ** 2) / whole
        share = np.minimum(sums[3] / whole, 1.0)
        fade, seconds = (
            np.exp(-sums[7] / TUNING.turns_memory_s),
            np.minimum(sums[7], TUNING.correction_sum_s),
        )
        strength = self.strength[slots]
        ratios = sums[5] * fade + seconds * share * strength * (share + ratio - 1.0)
        weights = sums[6] * fade + seconds * share * share
        self._sums[5:, slots] = ratios, weights, np.zeros(m)
        mean = ratios / np.maximum(weights, 1e-12)
        sure = mean > 1.0 + SURE_SIGMAS * np.sqrt(
            TUNING.ratio_variance * TUNING.correction_sum_s / np.maximum(weights, 1e-12)
        )
        sure &= weights > TUNING.correction_sum_s
        found = np.where(sure, np.minimum(mean, TUNING.largest_strength), 1.0)
        self._underestimated = max(1.0, float(found.sum() / strength.sum()))
        self.strength[slots] = found
