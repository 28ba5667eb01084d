# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Adapts the white measurement noise to the innovations (covariance matching: Mehra 1972).

Tests for faults compare innovations with their covariance. With a detector or an attitude that is
noisier than stated, every such test would fail now and then, for several robots at once. So the
ratio of actual to stated noise is estimated, and the filter uses it.

Only white noise counts. A manoeuvring robot, a turning camera or a telemetry jump also causes large
innovations, but similar ones for several images. Second differences e1 - 2 e2 + e3 of three
consecutive innovations cancel what is constant or linear in time; for white noise they have the
covariance S1 + 4 S2 + S3. The median of their normalised squares is robust against single images in
which a fault begins or a box is misassociated.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoiseLevelTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    level_images: int = 100
    """Images over which the level is estimated. Judged."""
    least_images: int = 20
    """Least number of images; with fewer its own sigma exceeds 0.45."""
    every_images: int = 5
    """Images between estimates. Judged."""
    level_sure_sigmas: float = 3.5
    """Sigmas above 1 from which the level is applied, so that correct noise is unaffected: one in
    4,000 by a Gaussian."""
    largest_level: float = 100.0
    """Upper bound of the level: ten times the stated standard deviations. Judged."""
    uneven_intervals: float = 1.5
    """Greatest ratio of consecutive intervals; beyond, linear terms do not cancel. Judged."""


TUNING = NoiseLevelTuning()


_MEDIAN = math.log(2.0)
"""Median of half the squared length of a planar Gaussian, whose mean is 1."""

_SPREAD = math.sqrt(1.94) / _MEDIAN
"""Relative sigma of the median of one value per image. That of n independent ones is 1 / (ln 2
sqrt(n)); the squares of overlapping second differences are correlated by 4/9 and 1/36, so that n of
them count as n / 1.94. Robots of one image share the pose's noise and count as one."""


_COVARIANCE = np.array([3, 4, 4, 5])

NO_INNOVATIONS = np.full((3, 6), np.nan)
"""Innovations of a track without any, see `NoiseLevel.update`."""
NO_INNOVATIONS.flags.writeable = False


class NoiseLevel:
    """Estimates the level from the innovations of all robots.

    Attributes:
        level: factor by which the variances of white noise exceed the stated ones; 1 if they may be
            as stated.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.level = 1.0
        # Packed: a hundred images are joined faster than their arrays.
        self._window: deque[bytes] = deque(maxlen=TUNING.level_images)
        self._since = 0

    def update(self, seen: Array) -> None:
        """Update with an image.

        Args:
            seen: (m, 3, 6) last three innovations of each robot in it, the latest last; NaN where
                there are fewer. An innovation is the offset of a box from its robot's predicted
                position: time (ns, from any origin), east, north (m), and the variance of east, the
                covariance and the variance of north (m²), divided by the level: mostly white noise,
                so about the stated ones.
        """
        ratios = _second_differences(seen)
        if not len(ratios):
            return
        self._window.append(ratios.tobytes())
        self._since += 1
        if self._since >= TUNING.every_images and len(self._window) >= TUNING.least_images:
            self._since = 0
            self._estimate()

    def _estimate(self) -> None:
        level = _median(np.frombuffer(b"".join(self._window))) / _MEDIAN
        sure = level > 1.0 + TUNING.level_sure_sigmas * _SPREAD / math.sqrt(len(self._window))
        self.level = min(level, TUNING.largest_level) if sure else 1.0


def _median(values: Array) -> float:
    """Return the median; numpy's takes longer to call than to compute."""
    middle = len(values) // 2
    low, high = middle - 1 + len(values) % 2, middle
    ordered = np.partition(values, (low, high))
    return 0.5 * float(ordered[low] + ordered[high])


def _second_differences(seen: Array) -> Array:
    """Return half the normalised squares, of mean 1, of robots with even intervals.

    Args:
        seen: (m, 3, 6), see `NoiseLevel.update`.
    """
    first, second, third = seen[:, 0], seen[:, 1], seen[:, 2]
    before, after = second[:, 0] - first[:, 0], third[:, 0] - second[:, 0]
    even = before / TUNING.uneven_intervals <= after  # false where one is missing
    even &= after <= before * TUNING.uneven_intervals
    offsets = (first - 2.0 * second + third)[:, 1:3]
    spread = (first + 4.0 * second + third)[:, _COVARIANCE].reshape(-1, 2, 2)
    ratios: Array = 0.5 * mahalanobis(offsets, spread)[0]
    return ratios[even]
