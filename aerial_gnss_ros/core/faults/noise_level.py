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

Before it is known, innovations have Student's t distribution, whose variance (`unknown`) the test
for a rotating camera expects.

Only robots tell it, not new tracks: where false boxes are all there is, the level would grow until
they were confirmed. What boxes told before the level was found counted too much, which is made good
once, as long as all images so far are among those of the estimate (`underestimated`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaincinv

from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS, Rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoiseLevelTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    level_images: int = 100
    """Images over which the level is estimated. Judged."""
    least_images: int = 4
    """Least number of images. With fewer only a level above 12 is sure."""
    every_images: int = 5
    """Images between estimates, once there are four times as many. Judged."""
    counts_anew: float = 1.5
    """Factor of the level above what images were counted by from which they count anew. Judged."""
    by_chance: float = 1.0 / 4000.0
    """Share of estimates in which correct noise looks larger, and the level is applied."""
    largest_level: float = 100.0
    """Upper bound of the level: ten times the stated standard deviations. Judged."""
    prior_degrees: float = 4.0
    """Degrees of freedom of the level before any image: one flight in 50 is three times as noisy as
    stated, by its standard deviations. Judged."""
    one_scale: float = 0.5
    """Probability that slow errors exceed the stated ones by the same factor as white noise does.
    Judged."""
    uneven_intervals: float = 1.5
    """Greatest ratio of consecutive intervals; beyond, linear terms do not cancel. Judged."""


TUNING = NoiseLevelTuning()


_MEDIAN = math.log(2.0)
"""Median of half the squared length of a planar Gaussian, whose mean is 1."""

_CORRELATED = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0)
"""So many squares of overlapping second differences count as one: they are correlated by 4/9 and
1/36. Robots of one image share the pose's noise and count as one."""


Innovations = tuple[float, ...]
"""Those of a robot in its last three images, 18 numbers, see `NoiseLevel.update`."""

NO_INNOVATIONS: Innovations = (math.nan,) * 18
"""Innovations of a track without any."""


class NoiseLevel:
    """Estimates the level from the innovations of all robots.

    Attributes:
        level: factor by which the variances of white noise exceed the stated ones; 1 if they may be
            as stated.
        underestimated: by what factor it was too small for all images so far, above 1 only where
            these are no more than the level is estimated from.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.level = self.underestimated = self._counted = 1.0
        self._degrees, self._seems = TUNING.prior_degrees, 1.0
        self._all = True
        # Values of all images in a row and their number in each: a snapshot shares them.
        self._values, self._sizes = b"", tuple[int, ...]()
        self._since = 0

    def update(self, seen: list[Innovations]) -> None:
        """Update with an image.

        Args:
            seen: last three innovations of each robot in it, one after the other, the latest last;
                NaN where there are fewer. Each is six numbers: time (ns, from any origin), offset
                of a box from its robot's predicted position east and north (m), and the variance of
                east, the covariance and the variance of north (m²), divided by the level: mostly
                white noise, so about the stated ones.
        """
        ratios = _second_differences(seen)
        if not len(ratios):
            return
        new = ratios.tobytes()
        if len(self._sizes) == TUNING.level_images:
            self._all = False
            self._values = self._values[self._sizes[0] :] + new
            self._sizes = (*self._sizes[1:], len(new))
        else:
            self._values, self._sizes = self._values + new, (*self._sizes, len(new))
        self._degrees = TUNING.prior_degrees + 2.0 * (len(self._values) // 8) / _CORRELATED
        self._since += 1
        due = min(TUNING.every_images, len(self._sizes) // 4)
        if self._since >= due:
            self._since = 0
            self._estimate()

    def _estimate(self) -> None:
        median = _median(np.frombuffer(self._values)) / _MEDIAN
        images, self._seems = len(self._sizes), min(median, TUNING.largest_level)
        sure = images >= TUNING.least_images and median > _sure_level(images)
        self.level = self._seems if sure else 1.0
        if self._all and self.level > TUNING.counts_anew * self._counted:
            self.underestimated = self.level / self._counted

    @property
    def unknown(self) -> float:
        """Variance of an innovation over that by `level`; above 1 while that is a guess."""
        return self._scale() * self._degrees / (self._degrees - 2.0)

    @property
    def of_slow_errors(self) -> float:
        """Factor of the prior variance of slow errors.

        As likely as not they exceed the stated ones by the same factor as white noise, which shows
        what the sensors are like: the mixture's variance.
        """
        return 1.0 + TUNING.one_scale * (self._counted - 1.0)

    def _scale(self) -> float:
        n, before = self._degrees, TUNING.prior_degrees
        return max(1.0, (before + (n - before) * self._seems) / (n * self.level))

    def take_underestimated(self) -> float:
        """Return `underestimated`, once."""
        factor, self.underestimated = self.underestimated, 1.0
        self._counted *= factor
        return factor


@cache
def _sure_level(images: int) -> float:
    """Return the level that correct noise exceeds once in `1 / TUNING.by_chance` estimates.

    The median of n independent values of an exponential distribution of mean 1 exceeds x if at
    least half of them do: binomial, each with probability exp(-x).
    """
    half = 0.5 * (images / _CORRELATED + 1.0)
    # The binomial's tail as an incomplete beta function, whose arguments need not be integers.
    each = float(betaincinv(half, half, TUNING.by_chance))
    return -math.log(each) / _MEDIAN


def _median(values: Array) -> float:
    """Return the median; numpy's takes longer to call than to compute."""
    middle = len(values) // 2
    low, high = middle - 1 + len(values) % 2, middle
    ordered = np.partition(values, (low, high))
    return 0.5 * float(ordered[low] + ordered[high])


def _second_differences(seen: list[Innovations]) -> Array:
    """Return half the normalised squares, of mean 1, of robots with even intervals.

    Args:
        seen: of each robot, see `NoiseLevel.update`.
    """
    if len(seen) <= MAX_ROWS:
        return np.array([ratio for ratio, even in _ratios(seen) if even])
    ((ratios, even),) = _ratios([np.array(seen).T])
    of_even: Array = ratios[even]
    return of_even


def _ratios(rows: Rows) -> list[tuple[Any, Any]]:
    """Return half the normalised square, and whether the intervals are even, of each row."""
    uneven, found = TUNING.uneven_intervals, list[tuple[Any, Any]]()
    for t1, x1, y1, a1, b1, d1, t2, x2, y2, a2, b2, d2, t3, x3, y3, a3, b3, d3 in rows:
        before, after = t2 - t1, t3 - t2
        even = (before / uneven <= after) & (after <= before * uneven)  # false if one is missing
        x, y = x1 - 2.0 * x2 + x3, y1 - 2.0 * y2 + y3
        a, b, d = a1 + 4.0 * a2 + a3, b1 + 4.0 * b2 + b3, d1 + 4.0 * d2 + d3
        squared = d * x * x - 2.0 * b * x * y + a * y * y
        found.append((0.5 * squared / (abs(a * d - b * b) + 1e-24), even))
    return found
