# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Joint Gaussians of the platform's errors and some robots, many side by side.

Each of the c Gaussians has the platform's slow errors (6), the pose's white noise of the present
image (6), and for each robot its East, North, their rates, and the error of its box (6). The white
noise is a state so that boxes of an image can be taken in one after the other, each with a weight
of its own, although they share it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import TUNING as STATE
from aerial_gnss_ros.core.numerics.gaussian import inverse

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SLOW, WHITE, COMMON, OWN = slice(0, 6), slice(6, 12), 12, 6
"""The platform's errors, the image's noise, how many these are, and how many a robot has."""


@dataclass(frozen=True)
class ShownPlaces:
    """Where the boxes of a robot are on the water.

    Attributes:
        places: (c, 2) East, North, m.
        by_common: (c, 2, 12) derivative of the place by platform's errors and white noise.
        by_box: (c, 2, 2) by the box, m/px.
        box_variance: (c,) of the box's error, each axis, px².
        valid: (c,) whether the box shows water.
    """

    places: Array
    by_common: Array
    by_box: Array
    box_variance: Array
    valid: Mask


@dataclass(frozen=True)
class BoxFit:
    """How m boxes differ from what is expected, before each is taken in.

    Attributes:
        squared: (c, m) normalised squared residuals.
        determinants: (c, m) of the residuals' covariances, px⁴.
    """

    squared: Array
    determinants: Array


class BankState:
    """c joint Gaussians of the same robots, in slots 0 to n - 1.

    Args:
        platform: (c, 6, 6) covariance of the platform's errors.
        speed: one sigma of a robot's unknown velocity, each axis, m/s.

    Attributes:
        mean: (c, 12 + 6 n).
        covariance: (c, 12 + 6 n, 12 + 6 n).
    """

    def __init__(self, platform: Array, speed: float) -> None:
        count = len(platform)
        self._speed = speed
        self.mean: Array = np.zeros((count, COMMON))
        self.covariance: Array = np.zeros((count, COMMON, COMMON))
        self.covariance[:, SLOW, SLOW] = platform

    @property
    def robots(self) -> Array:
        """(c, n, 6) means of robots."""
        return self.mean[:, COMMON:].reshape(len(self.mean), -1, OWN)

    def keep(self, slots: Sequence[int]) -> None:
        """Drop all robots but some, which come into this order."""
        some = np.arange(COMMON).tolist()
        for slot in slots:
            some += _places_of(slot).tolist()
        self.mean = self.mean[:, some]
        self.covariance = self.covariance[:, some][:, :, some]

    def predict(self, seconds: float, keep: Array, platform: Array, acceleration: Array) -> None:
        """Move on in time.

        Args:
            seconds: length of the step, s.
            keep: (c,) factor by which the platform's errors decay.
            platform: (c, 6, 6) covariance of these errors when nothing is known.
            acceleration: (c,) of robots, root of its spectral density, m/s^1.5.
        """
        x, P = self.mean, self.covariance
        x[:, SLOW] *= keep[:, None]
        P[:, SLOW] *= keep[:, None, None]
        P[:, :, SLOW] *= keep[:, None, None]
        P[:, SLOW, SLOW] += (1.0 - keep**2)[:, None, None] * platform
        n = self.robots.shape[1]
        if not n:
            return
        robots = self.robots
        robots[..., :2] += seconds * robots[..., 2:4]
        down = P[:, COMMON:].reshape(len(P), n, OWN, -1)
        down[:, :, :2] += seconds * down[:, :, 2:4]
        across = P[:, :, COMMON:].reshape(len(P), -1, n, OWN)
        for axis in (0, 1):  # apart: numpy is slow where the innermost loop is over two
            across[..., axis] += seconds * across[..., axis + 2]
        density = acceleration**2
        for slot in range(n):
            east = COMMON + OWN * slot
            for a in (east, east + 1):
                P[:, a, a] += density * seconds**3 / 3.0
                P[:, a, a + 2] += density * seconds**2 / 2.0
                P[:, a + 2, a] += density * seconds**2 / 2.0
                P[:, a + 2, a + 2] += density * seconds

    def begin_image(self, white: Array, box_keep: Array, box_variance: Array) -> None:
        """Begin with an image's own noise.

        Args:
            white: (c, 6) variances of the pose's white noise.
            box_keep: (c,) factor by which errors of boxes have decayed since the last image.
            box_variance: (c,) of these errors, px².
        """
        kept = np.ones_like(self.mean)
        kept[:, WHITE] = 0.0
        robots = kept[:, COMMON:].reshape(len(kept), -1, OWN)
        robots[..., 4:] = box_keep[:, None, None]
        self.mean *= kept
        self.covariance *= kept[:, :, None] * kept[:, None]
        variances = np.einsum("cii->ci", self.covariance)
        variances[:, WHITE] = white
        more = (1.0 - box_keep**2) * box_variance
        variances[:, COMMON:].reshape(len(kept), -1, OWN)[..., 4:] += more[:, None, None]

    def add(self, shown: ShownPlaces) -> None:
        """Add a robot where a box shows it."""
        count, size = self.mean.shape
        covariance = np.zeros((count, size + OWN, size + OWN))
        covariance[:, :size, :size] = self.covariance
        self.mean = np.concatenate([self.mean, np.zeros((count, OWN))], axis=1)
        self.covariance = covariance
        self.restart((size - COMMON) // OWN, shown, shown.valid)

    def restart(self, slot: int, shown: ShownPlaces, where: Mask) -> None:
        """Put a robot where a box shows it, in some of the Gaussians."""
        some = np.flatnonzero(where & shown.valid)
        own, size = _places_of(slot), self.mean.shape[1]
        x, P = self.mean[some], self.covariance[some]
        _clear(x, P, own)
        moved = np.zeros((len(some), OWN, size))
        moved[:, :2, :COMMON] = shown.by_common[some]
        cross = moved @ P
        spread = cross @ moved.swapaxes(1, 2)
        by_box, variance = shown.by_box[some], shown.box_variance[some, None, None]
        spread[:, :2, :2] += variance * (by_box @ by_box.swapaxes(1, 2))
        spread[:, :2, 4:] -= variance * by_box
        spread[:, 4:, :2] -= variance * by_box.swapaxes(1, 2)
        spread[:, 4:, 4:] += variance * np.eye(2)
        spread[:, (2, 3), (2, 3)] = self._speed**2
        P[:, own] = cross
        P[:, :, own] = cross.swapaxes(1, 2)
        P[:, own[:, None], own] = spread
        x[:, own[:2]] = shown.places[some]
        x[:, own[:2]] += (moved[:, :2, :COMMON] @ x[:, :COMMON, None])[..., 0]
        self.mean[some], self.covariance[some] = x, P

    def forget(self, where: Mask, platform: Array) -> None:
        """Forget in some of the Gaussians what all images so far have told.

        Args:
            where: (c,) in which.
            platform: (c, 6, 6) covariance of the platform's errors when nothing is known.
        """
        some = np.flatnonzero(where)
        x, P = self.mean[some], self.covariance[some]
        x[:, SLOW] = 0.0
        white = P[:, WHITE, WHITE].copy()
        P[:] = 0.0
        P[:, SLOW, SLOW], P[:, WHITE, WHITE] = platform[some], white
        each = np.arange(COMMON, P.shape[1])
        P[:, each, each] = STATE.wide_m**2
        self.mean[some], self.covariance[some] = x, P

    def correct(
        self, slots: Sequence[int], residuals: Array, seen: Mask, by_common: Array,
        by_place: Array, noise: Array, degrees: float,
    ) -> BoxFit:  # fmt: skip
        """Take in the boxes of m robots, one after the other, and return how each fitted.

        Their errors have Student's t distribution: a box that fits badly counts less. What a box
        tells is carried to those after it; the whole covariance follows once, at the end.

        Args:
            slots: (m,) of the robots.
            residuals: (c, m, 2) of the boxes by the present mean, px.
            seen: (c, m) whether a box is compared; the residuals of others are taken to be 0.
            by_common: (c, m, 2, 12) derivatives of pixels by platform's errors and white noise.
            by_place: (c, m, 2, 2) by the robots' places.
            noise: (c,) variance of the boxes beyond the error that is a state, px².
            degrees: of freedom; large: a Gaussian.
        """
        count, each = len(slots), np.arange(2 * len(slots))
        by = self._by_state(slots, by_common, by_place)
        told = by @ self.covariance
        spread = told @ by.swapaxes(1, 2)
        spread[:, each, each] += noise[:, None]
        off = residuals.reshape(-1, 2 * count, 1).copy()
        gains = np.empty_like(told)
        squared, determinants = np.empty((2, len(told), count))
        for i in range(count):
            own, later = slice(2 * i, 2 * i + 2), slice(2 * i + 2, None)
            box = spread[:, own, own]
            precision = inverse(box)
            determinants[:, i] = box[:, 0, 0] * box[:, 1, 1] - box[:, 0, 1] ** 2
            off[~seen[:, i], own] = 0.0
            residual = off[:, own]
            squared[:, i] = (residual.swapaxes(1, 2) @ precision @ residual)[:, 0, 0]
            weight = np.minimum((degrees + 2.0) / (degrees + squared[:, i]), 1.0)
            precision *= weight[:, None, None]
            gains[:, own] = precision @ told[:, own]
            carried = spread[:, later, own] @ precision
            off[:, later] -= carried @ residual
            told[:, later] -= carried @ told[:, own]
            spread[:, later] -= carried @ spread[:, own]
        gain = gains.swapaxes(1, 2)
        self.mean += (gain @ off)[..., 0]
        self.covariance -= gain @ told
        return BoxFit(squared, determinants)

    def _by_state(self, slots: Sequence[int], by_common: Array, by_place: Array) -> Array:
        """Return the derivatives (c, 2 m, 12 + 6 n) of boxes by the whole state, see `correct`."""
        by = np.zeros((*by_common.shape[:3], self.mean.shape[1]))
        by[..., :COMMON] = by_common
        for i, slot in enumerate(slots):
            east = COMMON + OWN * slot
            by[:, i, :, east : east + 2] = by_place[:, i]
            by[:, i, :, east + 4 : east + 6] = np.eye(2)
        return by.reshape(len(by), 2 * len(slots), -1)

    def symmetrise(self) -> None:
        """Take out what rounding adds up to over many images."""
        self.covariance = 0.5 * (self.covariance + self.covariance.swapaxes(1, 2))


def _places_of(slot: int) -> NDArray[np.intp]:
    """Return the columns (6,) of a robot."""
    return np.arange(COMMON + OWN * slot, COMMON + OWN * (slot + 1))


def _clear(mean: Array, covariance: Array, part: slice | NDArray[np.intp]) -> None:
    """Set some of the states to 0, exactly known."""
    mean[:, part] = 0.0
    covariance[:, part] = 0.0
    covariance[:, :, part] = 0.0
