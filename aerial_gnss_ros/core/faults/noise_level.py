# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How many times as large as stated the white noise of boxes and pose is, found from innovations.

Tests that ask whether robots are where they should be compare innovations with their covariance.
Where a detector or an attitude is noisier than stated, every such test fails now and then, for
several robots at once. So the noise itself is estimated, and the filter uses the estimate (adaptive
measurement noise by covariance matching: Mehra 1972).

Only white noise counts. A robot that manoeuvres, a camera that turns or telemetry that has jumped
also makes innovations large, but for several images in much the same way. Second differences of
three successive innovations e, e1 - 2 e2 + e3, leave out what is constant or linear in time; white
ones have the covariance S1 + 4 S2 + S3. The median of their normalised squares is not moved by
single images in which a fault begins or a box is confused with another.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class NoiseLevelTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    level_images: int = 100
    """Images that the estimate rests on. Judged."""
    least_images: int = 20
    """Images without which there is none. With fewer its own sigma is above 0.45."""
    every_images: int = 5
    """How often the estimate is made anew. Judged."""
    level_sure_sigmas: float = 3.5
    """Sigmas above 1 from which the estimate counts: noise that is as stated is left alone. One in
    4,000 of a normal law."""
    largest_level: float = 100.0
    """Largest level: ten times the stated standard deviations. Judged."""
    uneven_intervals: float = 1.5
    """Successive intervals may differ by this factor; else what is linear in time does not cancel.
    Judged."""


TUNING = NoiseLevelTuning()


_MEDIAN = math.log(2.0)
"""Of half a squared planar normal length, whose mean is 1."""

_SPREAD = math.sqrt(1.94) / _MEDIAN
"""One sigma of the relative error of the median of one value an image. That of n independent ones
is 1 / (ln 2 sqrt(n)); the squares of second differences that overlap are correlated by 4/9 and
1/36, so that n of them count as n / 1.94. Robots of one image share the pose's noise: they count as
one."""


@dataclass(frozen=True)
class Innovation:
    """Where a box was from where its robot was expected.

    Attributes:
        stamp_ns: of the image, ns.
        east: m.
        north: m.
        variances: of east, of both together, of north, m², divided by the level: white noise is
            most of them, so that they are about the stated ones.
    """

    stamp_ns: int
    east: float
    north: float
    variances: tuple[float, float, float]


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
        self._window: deque[tuple[float, ...]] = deque(maxlen=TUNING.level_images)
        self._since = 0

    def update(self, seen: Iterable[tuple[Innovation, ...]]) -> None:
        """Take in an image.

        Args:
            seen: of each robot that it shows, the last innovations, three at most.
        """
        ratios = _second_differences(seen)
        if not ratios:
            return
        self._window.append(ratios)
        self._since += 1
        if self._since >= TUNING.every_images and len(self._window) >= TUNING.least_images:
            self._since = 0
            self._estimate()

    def _estimate(self) -> None:
        level = float(np.median(np.concatenate(self._window))) / _MEDIAN
        sure = level > 1.0 + TUNING.level_sure_sigmas * _SPREAD / math.sqrt(len(self._window))
        self.level = min(level, TUNING.largest_level) if sure else 1.0


def _second_differences(seen: Iterable[tuple[Innovation, ...]]) -> tuple[float, ...]:
    """Return half the normalised squares, of mean 1, of robots at intervals that are alike.

    Args:
        seen: of each robot the last innovations; those of three count.
    """
    ratios: list[float] = []
    for last in seen:
        if len(last) < 3:
            continue
        one, two, three = last
        before, after = two.stamp_ns - one.stamp_ns, three.stamp_ns - two.stamp_ns
        if not before / TUNING.uneven_intervals <= after <= before * TUNING.uneven_intervals:
            continue
        x = one.east - 2.0 * two.east + three.east
        y = one.north - 2.0 * two.north + three.north
        (a1, b1, d1), (a2, b2, d2) = one.variances, two.variances
        a3, b3, d3 = three.variances
        a, b, d = a1 + 4.0 * a2 + a3, b1 + 4.0 * b2 + b3, d1 + 4.0 * d2 + d3
        squared = d * x * x - 2.0 * b * x * y + a * y * y
        ratios.append(0.5 * squared / max(a * d - b * b, 1e-24))
    return tuple(ratios)
