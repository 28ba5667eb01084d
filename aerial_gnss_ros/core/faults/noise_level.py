# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Adapts the white measurement noise to the innovations (covariance matching: Mehra 1972).

Tests for faults compare innovations with their covariance. With a detector or an attitude that is
noisier than stated, every such test would fail now and then, for several robots at once. So the
ratio of actual to stated noise is estimated, and the filter uses it.

Only white noise counts. A manoeuvring robot, a turning camera or a telemetry jump also causes large
innovations, but similar ones for several images. Second differences e1 - 2 e2 + e3 of three
consecutive innovations cancel what is constant or linear in time; for white noise they have the
covariance S1 + 4 S2 + S3. Not all of that is white noise: where images are seldom or boxes were
missed, much of it is motion that nobody knows. So each tells the level at which its normalised
square would be a median one, and the median of these levels is robust against single images in
which a fault begins or a box is misassociated.

The level has a scaled inverse chi-square prior, and no threshold: after few images it is near the
stated one, and gates that are a little wider let in the boxes that tell of more. Innovations have
Student's t distribution, whose variance (`unknown`) the test for a rotating camera expects.

Only robots tell it, not new tracks: where false boxes are all there is, the level would grow until
they were confirmed. What boxes told before the level was found counted too much, which is made good
once, as long as all images so far are among those of the estimate (`underestimated`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS, Rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoiseLevelTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    level_images: int = 100
    """Images over which the level is estimated. Judged."""
    every_images: int = 5
    """Images between estimates, once there are four times as many. Judged."""
    counts_anew: float = 2.5
    """Factor of the level above what images were counted by from which they count anew. Judged."""
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
"""Those of a robot in its last three images, 21 numbers, see `NoiseLevel.update`."""

NO_INNOVATIONS: Innovations = (math.nan,) * 21
"""Innovations of a track without any."""


class NoiseLevel:
    """Estimates the level from the innovations of all robots.

    Attributes:
        level: factor by which the variances of white noise exceed the stated ones, at least 1: mean
            of its scaled inverse chi-square posterior's scale.
        underestimated: by what factor it was too small for all images so far, above 1 only where
            these are no more than the level is estimated from.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.level = self.underestimated = self._counted = 1.0
        self._degrees = TUNING.prior_degrees
        self._all = True
        # Values of all images in a row and their number in each: a snapshot shares them.
        self._values, self._sizes = b"", tuple[int, ...]()
        self._since = 0

    def update(self, seen: list[Innovations]) -> None:
        """Update with an image.

        Args:
            seen: last three innovations of each robot in it, one after the other, the latest last;
                NaN where there are fewer. Each is seven numbers: time (ns, from any origin), offset
                of a box from its robot's predicted position east and north (m), and the variance of
                east, the covariance and the variance of north (m²), and how much of the sum of
                these variances is white noise as stated (m²; NaN: the box may be another robot's).
        """
        levels = _levels(seen, self.level)
        if not len(levels):
            return
        new = levels.tobytes()
        if len(self._sizes) == TUNING.level_images:
            self._all = False
            self._values = self._values[self._sizes[0] :] + new
            self._sizes = (*self._sizes[1:], len(new))
        else:
            self._values, self._sizes = self._values + new, (*self._sizes, len(new))
        self._since += 1
        due = min(TUNING.every_images, len(self._sizes) // 4)
        if self._since >= due:
            self._since = 0
            self._estimate()

    def _estimate(self) -> None:
        told = 2.0 * len(self._sizes) / _CORRELATED
        self._degrees = TUNING.prior_degrees + told
        median = min(_median(np.frombuffer(self._values)), TUNING.largest_level)
        self.level = max(1.0, (TUNING.prior_degrees + told * median) / self._degrees)
        if self._all and self.level > TUNING.counts_anew * self._counted:
            self.underestimated = self.level / self._counted

    @property
    def unknown(self) -> float:
        """Variance of an innovation over that by `level`; above 1 while that is a guess."""
        return self._degrees / (self._degrees - 2.0)

    @property
    def of_slow_errors(self) -> float:
        """Factor of the prior variance of slow errors.

        As likely as not they exceed the stated ones by the same factor as white noise, which shows
        what the sensors are like: the mixture's variance.
        """
        return 1.0 + TUNING.one_scale * (self._counted - 1.0)

    def take_underestimated(self) -> float:
        """Return `underestimated`, once."""
        factor, self.underestimated = self.underestimated, 1.0
        self._counted *= factor
        return factor


def _median(values: Array) -> float:
    """Return the median; numpy's takes longer to call than to compute."""
    middle = len(values) // 2
    low, high = middle - 1 + len(values) % 2, middle
    ordered = np.partition(values, (low, high))
    return 0.5 * float(ordered[low] + ordered[high])


def _levels(seen: list[Innovations], level: float) -> Array:
    """Return of each robot with even intervals the level at which its difference is a median one.

    Half the normalised square of a difference of covariance C has the median ln 2, and C grows by
    the white noise W in it: with the trace's share of that, at the level 1 + (q / ln 2 - 1) C / W.
    The median of these levels is where half of the squares exceed their medians.

    Args:
        seen: of each robot, see `NoiseLevel.update`.
        level: by which the covariances were computed.
    """
    if len(seen) <= MAX_ROWS:
        return level + np.array([more for more, even in _ratios(seen) if even])
    ((beyond, even),) = _ratios([np.array(seen).T])
    of_even: Array = level + beyond[even]
    return of_even


def _ratios(rows: Rows) -> list[tuple[Any, Any]]:
    """Return by how much the level is larger, and whether the intervals are even, of each row."""
    uneven, found = TUNING.uneven_intervals, list[tuple[Any, Any]]()
    for t1, x1, y1, a1, b1, d1, w1, t2, x2, y2, a2, b2, d2, w2, t3, x3, y3, a3, b3, d3, w3 in rows:
        before, after = t2 - t1, t3 - t2
        white = w1 + 4.0 * w2 + w3
        # False if one is missing.
        even = (before / uneven <= after) & (after <= before * uneven) & (white > 0.0)
        x, y = x1 - 2.0 * x2 + x3, y1 - 2.0 * y2 + y3
        a, b, d = a1 + 4.0 * a2 + a3, b1 + 4.0 * b2 + b3, d1 + 4.0 * d2 + d3
        squared = d * x * x - 2.0 * b * x * y + a * y * y
        ratio = 0.5 * squared / (abs(a * d - b * b) + 1e-24) / _MEDIAN
        found.append(((ratio - 1.0) * (a + d) / (white + 1e-24), even))
    return found
