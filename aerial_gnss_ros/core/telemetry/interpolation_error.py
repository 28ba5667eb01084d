# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Error of values interpolated between two samples: what the platform may have done between them.

The rate of a value is taken for a random walk of spectral density q. In a gap of T, a time s after
its first sample, the value is then off the straight line between its ends by the variance

    q s² (T - s)² / 3T,

q T³ / 48 in the middle (the bridge of an integrated Wiener process whose rate is unknown). The
samples themselves show q: each lies off the line between its neighbours likewise. The
gap itself counts besides the average, since a platform that was calm may turn just in it.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, wrap_angle
from aerial_gnss_ros.core.geometry.geodesy import SEMI_MAJOR_M
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_vector
from aerial_gnss_ros.core.telemetry.interpolation import (
    interpolate_fixes,
    interpolate_orientations,
    interpolate_scalars,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

Array = NDArray[np.float64]
T = TypeVar("T", Fix, Orientation, Scalar)


@dataclass(frozen=True)
class InterpolationErrorTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    moved: float = 0.5
    """Density expected of a position or height, m²/s³: 0.1 m in the middle of a second. A drone
    that accelerates by 0.5 m/s² for a second at a time. Judged."""
    turned: float = 0.002
    """Density expected of an orientation, rad²/s³: 0.4 deg in the middle of a second. Judged."""
    weight: float = 4.0
    """Number of samples that the expected density counts for. Judged."""
    own_weight: float = 1.0
    """Weight of a gap's own neighbours, against 1 for the average. Judged."""
    lag_s: float = 0.45
    """Least time between samples that are compared, s: in less, noise hides the motion."""
    memory_s: float = 60.0
    """Time constant with which older samples count less, s. Judged."""
    longest_s: float = 10.0
    """Samples farther apart show nothing of the motion between them, s. Judged."""


TUNING = InterpolationErrorTuning()


@dataclass(frozen=True)
class Uncertain:
    """The error of one interpolated value.

    Attributes:
        variance: (k,) of each kind of component: see `InterpolationError`.
        gap_s: time between the two samples, s: errors at times between them are correlated.
    """

    variance: tuple[float, ...]
    gap_s: float


class InterpolationError(Generic[T]):
    """Learns from an input's samples how far off values between them may be.

    Components are of one kind: the mean of East and North (m²) for fixes; for orientations the mean
    of the rotations about the level axes, and that about the upward axis (rad²); heights (m²).

    Args:
        between: interpolates two samples at a fraction from 0 to 1 and stamps the result.
        squares: squared difference of two samples, by kind of component.
        expected: (k,) densities before any sample, in the components' units a cubic second.
    """

    def __init__(
        self,
        between: Callable[[T, T, float, int], T],
        squares: Callable[[T, T], tuple[float, ...]],
        expected: tuple[float, ...],
    ) -> None:
        self._between: Callable[[T, T, float, int], T] = between
        self._squares: Callable[[T, T], tuple[float, ...]] = squares
        self._expected = expected
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self._earlier: T | None = None
        self._middle: T | None = None
        self._sum = (0.0,) * len(self._expected)
        self._weight = 0.0
        self._ends_ns: deque[int] = deque(maxlen=round(TUNING.memory_s / TUNING.lag_s))
        self._found: deque[tuple[float, ...]] = deque(maxlen=self._ends_ns.maxlen)

    def interrupt(self) -> None:
        """Compare no sample with earlier ones: the sensor has jumped."""
        self._earlier = self._middle = None

    def add(self, value: T) -> None:
        """Take in a sample that is right, in the order of stamps; others are skipped."""
        middle, earlier = self._middle, self._earlier
        if middle is None:
            self._middle = value
            return
        after = (value.stamp_ns - middle.stamp_ns) * 1e-9
        if after < TUNING.lag_s:
            return
        self._earlier, self._middle = middle, value
        if earlier is None:
            return
        before = (middle.stamp_ns - earlier.stamp_ns) * 1e-9
        if before + after <= TUNING.longest_s:
            self._note(earlier, middle, value, before, after)

    def _note(self, earlier: T, middle: T, value: T, before: float, after: float) -> None:
        whole = before + after
        line = self._between(earlier, value, before / whole, middle.stamp_ns)
        scale = 3.0 * whole / (before * after) ** 2
        found = tuple(scale * square for square in self._squares(line, middle))
        if not all(map(math.isfinite, found)):
            return
        keep = math.exp(-after / TUNING.memory_s)
        self._sum = tuple(keep * a + b for a, b in zip(self._sum, found, strict=True))
        self._weight = keep * self._weight + 1.0
        self._ends_ns.append(value.stamp_ns)
        self._found.append(found)

    def at(self, stamp_ns: int, since_s: float, gap_s: float) -> Uncertain:
        """Return the error of a value interpolated in a gap.

        Args:
            stamp_ns: time of the value, ns.
            since_s: time from one of the gap's samples to it, s.
            gap_s: time between these samples, s.
        """
        prior, share = TUNING.weight, TUNING.own_weight
        total = prior + self._weight
        density = [(prior * a + b) / total for a, b in zip(self._expected, self._sum, strict=True)]
        if gap_s >= TUNING.lag_s and self._ends_ns:
            place = min(bisect_left(self._ends_ns, stamp_ns), len(self._ends_ns) - 1)
            own = self._found[place]
            density = [(a + share * b) / (1.0 + share) for a, b in zip(density, own, strict=True)]
        shape = (since_s * (gap_s - since_s)) ** 2 / (3.0 * gap_s)
        return Uncertain(tuple(shape * one for one in density), gap_s)


def fix_error() -> InterpolationError[Fix]:
    """Return what learns of the drone's positions."""
    return InterpolationError(interpolate_fixes, _fix_squares, (TUNING.moved,))


def orientation_error() -> InterpolationError[Orientation]:
    """Return what learns of orientations."""
    expected = (TUNING.turned, TUNING.turned)
    return InterpolationError(interpolate_orientations, _orientation_squares, expected)


def scalar_error() -> InterpolationError[Scalar]:
    """Return what learns of heights."""
    return InterpolationError(interpolate_scalars, _scalar_squares, (TUNING.moved,))


def _fix_squares(one: Fix, other: Fix) -> tuple[float, ...]:
    north = SEMI_MAJOR_M * (other.latitude - one.latitude)
    turn = float(wrap_angle(other.longitude - one.longitude))
    east = SEMI_MAJOR_M * math.cos(one.latitude) * turn
    return (0.5 * (north * north + east * east),)


def _orientation_squares(one: Orientation, other: Orientation) -> tuple[float, ...]:
    turn = matrix_from_quaternion(other.quaternion) @ matrix_from_quaternion(one.quaternion).T
    if not math.isfinite(float(turn.sum())):
        return math.nan, math.nan
    x, y, z = rotation_vector(turn).tolist()
    return 0.5 * (x * x + y * y), z * z


def _scalar_squares(one: Scalar, other: Scalar) -> tuple[float, ...]:
    return ((other.value - one.value) ** 2,)
