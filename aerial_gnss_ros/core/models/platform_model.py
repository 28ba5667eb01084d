# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The platform's slowly varying errors: names, order in the state, and sigmas.

A stated standard deviation is a prior: that error may be larger in this flight. With a scaled
inverse chi-square prior of its variance an error has Student's t distribution, whose variance is
`wider` times the stated one. How quickly it drifts stays as stated, so a larger error also lasts
longer, as one of the mounting does. The receiver's offset is as large as its fix says.

A compass on board deviates by the drone's iron, differently on each heading: by B sin + C cos of it
(coefficients of a mariner's deviation table). B and C are errors of their own, `DEVIATION`, so that
a heading's error is learnt again where the camera has turned. They are in no parameter.
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

PLATFORM = (
    "gnss_east", "gnss_north", "height", "roll", "pitch", "heading",
    "deviation_east", "deviation_north", "latency",
)  # fmt: skip
"""Corrections to measured values: m, m, m, rad, rad, rad, rad, rad, s. The angles rotate the camera
about the axes of `gimbal.error_axes`; deviations do so about the vertical, by sine and cosine of
its azimuth; a latency is added to `camera.latency_s`."""

COUNT = len(PLATFORM)
HEIGHT, LATENCY = PLATFORM.index("height"), PLATFORM.index("latency")
GNSS = slice(0, 2)
"""East and North of the receiver's offset."""
HEADING = PLATFORM.index("heading")
ANGLES = slice(PLATFORM.index("roll"), HEADING + 1)
DEVIATION = slice(ANGLES.stop, LATENCY)
SLOW = slice(ANGLES.stop)
"""Errors of the pose that are stated: all before the deviation."""
PUBLISHED = (*PLATFORM[SLOW], PLATFORM[LATENCY])
"""Errors under whose names something is published: the heading contains the deviation there."""
_WITHOUT_DEVIATION = np.delete(np.eye(COUNT), DEVIATION, axis=0)


def at_azimuth(mean: Array, covariance: Array, axes: Array | None) -> tuple[Array, Array]:
    """Return the errors (9,) of `PUBLISHED` and their covariance (9, 9) for a camera.

    Args:
        mean: (9,) of `PLATFORM`.
        covariance: (9, 9) of it.
        axes: (3, 3) of roll, pitch and heading errors of the camera, see `gimbal.error_axes`; None:
            no image has come yet.
    """
    through = _WITHOUT_DEVIATION.copy()
    if axes is not None:
        through[HEADING, DEVIATION] = axes[:2, 0]
    return through @ mean, through @ covariance @ through.T


def named_errors(mean: Array, covariance: Array, axes: Array | None) -> tuple[PlatformError, ...]:
    """Return the errors with their sigmas by name, see `at_azimuth`, without disabled ones.

    A sigma of 0 means that the error is not estimated.
    """
    mean, covariance = at_azimuth(mean, covariance, axes)
    variances = covariance.diagonal().tolist()
    found: list[PlatformError] = []
    for name, value, variance in zip(PUBLISHED, mean.tolist(), variances, strict=True):
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
    deviates: float = 1.0 / 3.0
    """Sigma of each coefficient of the compass's deviation over the heading's stated one. Judged:
    0.5 deg, as of a compass that was swung; larger ones are learnt where the camera turns."""


TUNING = PlatformModelTuning()


class PlatformModel:
    """Each error is a first-order Gauss-Markov process; a sigma of 0 disables it.

    Args:
        noise: standard deviations and the correlation time.
        reference: of the gimbal; says whether the body's attitude noise enters.
        exact: whether the standard deviations are known, as those of a simulation are.

    Attributes:
        correlation_time_s: stated, of all of them; 0 means white from image to image.
        wider: (9,) variances over the stated ones.
        white: (6,) variances of the pose's white noise: East, North, height (m²), and rotation
            about East, North, Up (rad²).
        pixel: variance of a box's centre, each axis, px².
        nominal: (9, 9) prior covariance of the errors.
    """

    def __init__(self, noise: Noise, reference: Reference | str, exact: bool = False) -> None:
        degrees = ("gimbal_roll_deg", "gimbal_pitch_deg", "heading_deg")
        gnss = noise.value("gnss_offset_m")
        sigma = [gnss, gnss, noise.value("height_m")]
        sigma += [math.radians(noise.value(name)) for name in degrees]
        deviates = 0.0 if exact else TUNING.deviates * sigma[HEADING]
        sigma += [deviates, deviates, noise.value("latency_s")]
        self.wider: Array = np.ones(COUNT)
        if not exact:
            of_size = TUNING.size_degrees / (TUNING.size_degrees - 2.0)
            self.wider[HEIGHT] = self.wider[ANGLES] = of_size
        self.nominal: Array = np.diag(self.wider * np.square(sigma))
        self.correlation_time_s = noise.value("correlation_time_s")
        level = noise.value("gnss_white_m") ** 2
        turn = white_rotation(noise, Reference(reference))
        self.white = np.array([level, level, noise.value("height_white_m") ** 2, *turn])
        self.pixel = noise.value("box_center_px") ** 2

    def stationary(self, fix_covariance: Array | None) -> Array:
        """Return the (9, 9) prior covariance of the errors.

        Args:
            fix_covariance: (2, 2) East, North of the fix itself, in place of the configured one.
        """
        if fix_covariance is None or not all_finite(fix_covariance):
            return self.nominal
        covariance = self.nominal.copy()
        covariance[:2, :2] = fix_covariance
        return covariance

    def stated(self, stationary: Array) -> Array:
        """Return what of a prior covariance (9, 9) was stated: no deviation, nothing wider."""
        covariance = stationary / self.wider
        covariance[DEVIATION] = 0.0
        return covariance

    def decay(self, seconds: float, correlation_time_s: float | None = None) -> Array:
        """Return the factors (9,) by which the errors decay over a time.

        Args:
            seconds: length of that time, s.
            correlation_time_s: another one than `self.correlation_time_s`.
        """
        kept = np.zeros(COUNT)
        lasts_s = self.correlation_time_s if correlation_time_s is None else correlation_time_s
        if lasts_s > 0.0:
            kept[:] = np.exp(-seconds / (self.wider * lasts_s))
        kept[LATENCY] = math.exp(-seconds / TUNING.latency_time_s)
        return kept
