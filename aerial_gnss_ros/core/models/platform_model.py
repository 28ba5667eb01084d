# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The platform's slowly varying errors: names, order in the state, and sigmas.

A stated standard deviation is a prior: that error may be larger in this flight. With a scaled
inverse chi-square prior of its variance an error has Student's t distribution, whose variance is
`wider` times the stated one. How quickly it drifts stays as stated, so a larger error also lasts
longer, as one of the mounting does. The receiver's offset is as large as its fix says.

A compass on board deviates by the drone's iron, differently on each heading (B sin + C cos of a
mariner's deviation table). So the heading's error changes as the camera turns, too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.gimbal import Reference
from aerial_gnss_ros.core.georeferencing.covariance import white_rotation
from aerial_gnss_ros.core.numerics.small_arrays import all_finite
from aerial_gnss_ros.core.values.estimates import PlatformError

Array = NDArray[np.float64]

PLATFORM = ("gnss_east", "gnss_north", "height", "roll", "pitch", "heading", "latency")
"""Corrections to measured values: m, m, m, rad, rad, rad, s. The angles rotate the camera about the
axes of `gimbal.error_axes`; a latency is added to `camera.latency_s`."""

COUNT = len(PLATFORM)
HEIGHT, LATENCY = PLATFORM.index("height"), PLATFORM.index("latency")
GNSS = slice(0, 2)
"""East and North of the receiver's offset."""
HEADING = PLATFORM.index("heading")
ANGLES = slice(PLATFORM.index("roll"), HEADING + 1)


def named_errors(mean: Array, covariance: Array) -> tuple[PlatformError, ...]:
    """Return the errors (7,) with sigmas of their covariance (7, 7) by name, without disabled ones.

    A sigma of 0 means that the error is not estimated.
    """
    variances = covariance.diagonal().tolist()
    found: list[PlatformError] = []
    for name, value, variance in zip(PLATFORM, mean.tolist(), variances, strict=True):
        if variance > 0.0:
            found.append(PlatformError(name, value, math.sqrt(variance)))
    return tuple(found)


@dataclass(frozen=True)
class PlatformModelTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    latency_time_s: float = 3600.0
    """Correlation time of the latency, s, which is a property of camera and recorder."""
    size_degrees: float = 5.0
    """Degrees of freedom of the prior of the variances of height and angles: one flight in 50 has
    errors 2.6 times as large as stated. Judged: with 4 a real flight's swimmers exchange labels."""
    deviates_rad: float = 4.0
    """Turn within which the heading's error changes as within its correlation time, rad. Judged:
    so 5 deg of deviation by the drone's own iron are contained, with 16 rad they are not."""


TUNING = PlatformModelTuning()


class PlatformModel:
    """Each error is a first-order Gauss-Markov process; a sigma of 0 disables it.

    Args:
        noise: standard deviations and the correlation time.
        reference: of the gimbal; says whether the body's attitude noise enters.
        exact: whether the standard deviations are known, as those of a simulation are.

    Attributes:
        correlation_time_s: stated, of all of them; 0 means white from image to image.
        wider: (7,) variances over the stated ones.
        white: (6,) variances of the pose's white noise: East, North, height (m²), and rotation
            about East, North, Up (rad²).
        pixel: variance of a box's centre, each axis, px².
        nominal: (7, 7) prior covariance of the errors.
    """

    def __init__(self, noise: Noise, reference: Reference | str, exact: bool = False) -> None:
        degrees = ("gimbal_roll_deg", "gimbal_pitch_deg", "heading_deg")
        gnss = noise.value("gnss_offset_m")
        sigma = [gnss, gnss, noise.value("height_m")]
        sigma += [math.radians(noise.value(name)) for name in degrees]
        sigma += [noise.value("latency_s")]
        self.wider: Array = np.ones(COUNT)
        self._exact = exact
        if not exact:
            self.wider[HEIGHT:LATENCY] = TUNING.size_degrees / (TUNING.size_degrees - 2.0)
        self.nominal: Array = np.diag(self.wider * np.square(sigma))
        self.correlation_time_s = noise.value("correlation_time_s")
        level = noise.value("gnss_white_m") ** 2
        turn = white_rotation(noise, Reference(reference))
        self.white = np.array([level, level, noise.value("height_white_m") ** 2, *turn])
        self.pixel = noise.value("box_center_px") ** 2

    def stationary(self, fix_covariance: Array | None) -> Array:
        """Return the (7, 7) prior covariance of the errors.

        Args:
            fix_covariance: (2, 2) East, North of the fix itself, in place of the configured one.
        """
        if fix_covariance is None or not all_finite(fix_covariance):
            return self.nominal
        covariance = self.nominal.copy()
        covariance[:2, :2] = fix_covariance
        return covariance

    def decay(
        self, seconds: float, correlation_time_s: float | None = None, turned_rad: float = 0.0
    ) -> Array:
        """Return the factors (7,) by which the errors decay over a time.

        Args:
            seconds: length of that time, s.
            correlation_time_s: another one than `self.correlation_time_s`.
            turned_rad: turn of the camera about the vertical meanwhile, rad.
        """
        kept = np.zeros(COUNT)
        lasts_s = self.correlation_time_s if correlation_time_s is None else correlation_time_s
        if lasts_s > 0.0:
            kept[:] = np.exp(-seconds / (self.wider * lasts_s))
        if not self._exact:
            kept[HEADING] *= math.exp(-turned_rad / (self.wider[HEADING] * TUNING.deviates_rad))
        kept[-1] = math.exp(-seconds / TUNING.latency_time_s)
        return kept
