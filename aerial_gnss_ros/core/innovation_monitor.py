# SPDX-License-Identifier: Apache-2.0
"""Watches whether boxes fall where the filter expects them, as closely as it expects them.

Two signs of noise that is stated wrongly: normalised squared residuals that are too large on
average (chi-square law, Bar-Shalom, Li, Kirubarajan 2001, 5.4), and an estimated platform error
that is many times its stated sigma.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.joint_platform import PLATFORM

Array = NDArray[np.float64]

WINDOW_IMAGES = 100
LEAST_COUNT = 60
"""Residuals below which nothing is said."""

ALARM_SIGMAS = 4.5
"""How far the mean may leave 1, in its own sigma. Residuals of one robot are not quite independent
from image to image, and the gate cuts the tail."""

CALM_SIGMAS = 2.5
"""Below which an alarm ends."""

PLATFORM_SIGMAS = 3.5
"""An estimated platform error so many times its stated sigma is not credible."""

_WORDS = {
    "gnss_east": ("GNSS offset to the east", "noise.gnss_offset_m", 1.0, "m"),
    "gnss_north": ("GNSS offset to the north", "noise.gnss_offset_m", 1.0, "m"),
    "height": ("height above the water", "noise.height_m", 1.0, "m"),
    "roll": ("camera's roll", "noise.gimbal_roll_deg", 180.0 / math.pi, "deg"),
    "pitch": ("camera's pitch", "noise.gimbal_pitch_deg", 180.0 / math.pi, "deg"),
    "heading": ("heading", "noise.heading_deg", 180.0 / math.pi, "deg"),
    "latency": ("latency", "noise.latency_s", 1.0, "s"),
}


@dataclass(frozen=True)
class Fit:
    """How residuals compare with their stated covariance.

    Attributes:
        ratio: mean normalised squared residual of a degree of freedom; 1 is right. NaN at first.
        sigmas: how far that is from 1, in its own sigma.
        alarm: whether the stated noise looks too small.
    """

    ratio: float
    sigmas: float
    alarm: bool


class InnovationMonitor:
    """Takes in each image's fit, and says in words when it becomes bad."""

    def __init__(self) -> None:
        self._window: deque[tuple[float, int]] = deque(maxlen=WINDOW_IMAGES)
        self._alarm = False
        self._told: set[str] = set()

    def reset(self) -> None:
        """Forget everything."""
        self._window.clear()
        self._alarm = False
        self._told.clear()

    @property
    def fit(self) -> Fit:
        """The fit over the last images."""
        squared = sum(item[0] for item in self._window)
        count = sum(item[1] for item in self._window)
        if count < LEAST_COUNT:
            return Fit(math.nan, 0.0, self._alarm)
        ratio = squared / count
        sigmas = (ratio - 1.0) / math.sqrt(2.0 / count)
        return Fit(ratio, sigmas, self._alarm)

    def take(self, squared: float, count: int) -> str | None:
        """Take in an image; return a sentence when an alarm begins or ends.

        Args:
            squared: normalised squared residual of the image.
            count: its degrees of freedom.
        """
        self._window.append((squared, count))
        fit = self.fit
        if not self._alarm and fit.sigmas > ALARM_SIGMAS:
            self._alarm = True
            return (
                f"Boxes lie {math.sqrt(fit.ratio):.1f} times as far from where they are expected "
                "as the stated noise allows: positions are less certain than published. Check the "
                "noise.* parameters, camera.latency_s and the compass."
            )
        if self._alarm and fit.sigmas < CALM_SIGMAS and not math.isnan(fit.ratio):
            self._alarm = False
            return "Boxes lie where they are expected again, within the stated noise."
        return None

    def check_platform(self, errors: Array, stationary: Array) -> str | None:
        """Return a sentence when an estimated error is far outside what is stated, once each.

        Args:
            errors: (7,) estimated, see `joint_platform.PLATFORM`.
            stationary: (7, 7) covariance stated.
        """
        sigma = np.sqrt(np.diag(stationary))
        for i in np.flatnonzero(np.abs(errors) > PLATFORM_SIGMAS * np.maximum(sigma, 1e-12)):
            name = PLATFORM[i]
            if name in self._told:
                continue
            self._told.add(name)
            words, parameter, scale, unit = _WORDS[name]
            return (
                f"The {words} seems wrong by {scale * errors[i]:.2g} {unit}, which is "
                f"{abs(errors[i]) / sigma[i]:.1f} times the stated sigma ({parameter}): calibrate "
                "it or state a larger one."
            )
        return None
