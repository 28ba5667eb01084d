# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Innovation monitor: are innovations consistent with their covariance?

Three signs of wrong noise parameters: a mean normalised squared residual that is too large
(chi-square test, Bar-Shalom, Li, Kirubarajan 2001, 5.4), an estimated platform error that is many
times its stated sigma, and many boxes near but outside their robots' gates.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.models.platform_model import PUBLISHED
from aerial_gnss_ros.core.values.events import WarningText

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ConsistencyTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    fit_images: int = 100
    """Images over which residuals are averaged. Judged."""
    least_residuals: int = 60
    """Least number of residuals for a warning. Judged."""
    alarm_sigmas: float = 4.5
    """Deviation of the mean from 1 at which a warning begins, in its sigma. Residuals of one robot
    are slightly correlated from image to image, and the gate cuts the tail."""
    calm_sigmas: float = 2.5
    """Deviation below which the warning ends. Judged."""
    platform_sigmas: float = 3.5
    """An estimated platform error beyond this many stated sigmas is not credible. Judged."""
    outside_share: float = 0.03
    """Share of boxes near but outside their robot's gate at which a warning is given. By the gate's
    probability it is ten times less with correct noise."""
    turned_rad: float = math.radians(1.0)
    """Camera rotation, one sigma, above which a warning is given, rad. Judged."""


TUNING = ConsistencyTuning()


_WORDS = {
    "gnss_east": ("drone's east position", "noise.gnss_offset_m", 1.0, "m"),
    "gnss_north": ("drone's north position", "noise.gnss_offset_m", 1.0, "m"),
    "height": ("height above the water", "noise.height_m", 1.0, "m"),
    "roll": ("camera's roll", "noise.gimbal_roll_deg", 180.0 / math.pi, "deg"),
    "pitch": ("camera's pitch", "noise.gimbal_pitch_deg", 180.0 / math.pi, "deg"),
    "heading": ("heading", "noise.heading_deg", 180.0 / math.pi, "deg"),
    "latency": ("latency", "noise.latency_s", 1.0, "s"),
}


@dataclass(frozen=True)
class InnovationStatistics:
    """Comparison of residuals with their stated covariance.

    Attributes:
        ratio: mean normalised squared residual of a degree of freedom; 1 is right. NaN at first.
        sigmas: its deviation from 1, in its own sigma.
        alarm: whether the stated noise looks too small.
    """

    ratio: float
    sigmas: float
    alarm: bool


class InnovationMonitor:
    """Monitors each image's fit, and reports inconsistency in words.

    Attributes:
        quick_s: time within which the platform's errors change, where that is not the stated one,
            s; 0: it is.
    """

    def __init__(self) -> None:
        self.quick_s = 0.0
        # Of each of the last images: squared residual, degrees of freedom. An array, which a
        # snapshot copies as one block.
        self._window = np.zeros((TUNING.fit_images, 2))
        self._images = 0
        self._squared, self._count = 0.0, 0
        self._alarm, self._level = False, 1.0
        self._told: set[str] = set()
        self._incredible: dict[str, str] = {}
        self._matched: deque[int] = deque(maxlen=TUNING.fit_images)
        self._missed: deque[int] = deque(maxlen=TUNING.fit_images)
        self._turned = ""

    def reset(self) -> None:
        """Forget everything."""
        self.quick_s = 0.0
        self._window, self._images = np.zeros((TUNING.fit_images, 2)), 0
        self._squared, self._count = 0.0, 0
        self._alarm, self._level = False, 1.0
        self._told.clear()
        self._incredible.clear()
        self._matched.clear()
        self._missed.clear()
        self._turned = ""

    @property
    def complaints(self) -> tuple[str, ...]:
        """Present inconsistencies, in sentences; empty without any."""
        misfit = (_misfit(self.fit.ratio, self._level),) if self._alarm else ()
        turned = (self._turned,) if self._turned else ()
        quick = (_quick(self.quick_s),) if self.quick_s else ()
        return (*misfit, *quick, *self._incredible.values(), *self._outside(), *turned)

    def _outside(self) -> tuple[str, ...]:
        matched, missed = sum(self._matched), sum(self._missed)
        if matched + missed < TUNING.least_residuals // 2 or missed <= TUNING.outside_share * (
            matched + missed
        ):
            return ()
        words = (
            f"{missed} of {matched + missed} boxes are outside their robot's gate and are not "
            "used: camera.latency_s, the compass, the gimbal or the noise.* parameters may be "
            "wrong."
        )
        return (words,)

    @property
    def fit(self) -> InnovationStatistics:
        """The fit over the last images."""
        count = self._count
        if count < TUNING.least_residuals:
            return InnovationStatistics(math.nan, 0.0, self._alarm)
        ratio = self._squared / count
        sigmas = (ratio - 1.0) / math.sqrt(2.0 / count)
        return InnovationStatistics(ratio, sigmas, self._alarm)

    def update(self, squared: float, count: int, level: float = 1.0) -> str | None:
        """Update with an image; return a sentence when an alarm begins or ends.

        Args:
            squared: squared residual of the image, normalised by the filter's noise.
            count: its degrees of freedom.
            level: factor by which that noise is larger than stated, see `noise_level`.
        """
        self._level = level
        squared *= level
        oldest = self._images % TUNING.fit_images
        old_squared, old_count = self._window[oldest].tolist()  # 0 at first
        self._window[oldest] = squared, count
        self._images += 1
        self._squared = self._squared + squared - old_squared
        self._count += count - int(old_count)
        fit = self.fit
        if not self._alarm and fit.sigmas > TUNING.alarm_sigmas:
            self._alarm = True
            return WarningText(_misfit(fit.ratio, level))
        if self._alarm and fit.sigmas < TUNING.calm_sigmas and not math.isnan(fit.ratio):
            self._alarm = False
            return "Boxes are where they are expected again, within the stated noise."
        return None

    def update_image(
        self,
        squared: float,
        count: int,
        level: float,
        turned: float,
        errors: Array,
        stationary: Array,
    ) -> list[str]:
        """Update with the filter's outcome for an image; return sentences for the log.

        Args:
            squared: squared residual, see `update`.
            count: its degrees of freedom.
            level: factor of the noise, see `update`.
            turned: rotation of the camera, see `update_rotation`.
            errors: (7,) of the platform, see `check_platform`.
            stationary: (7, 7) covariance stated.
        """
        news = (
            self.update(squared, count, level),
            self.update_rotation(turned),
            self.check_platform(errors, stationary),
        )
        return [one for one in news if one is not None]

    def update_matches(self, matched: int, missed: int) -> None:
        """Update with the numbers of robots with a box in their gate, and just outside."""
        self._matched.append(matched)
        self._missed.append(missed)

    def update_rotation(self, sigma: float) -> str | None:
        """Update with the possible rotation of the camera, one sigma, rad.

        Returns:
            A sentence when that begins.
        """
        begins = not self._turned and sigma > TUNING.turned_rad
        self._turned = _turned(sigma) if sigma > TUNING.turned_rad else ""
        return WarningText(self._turned) if begins else None

    def check_platform(self, errors: Array, stationary: Array) -> str | None:
        """Return a sentence for an estimated error far beyond its stated sigma, once each.

        Args:
            errors: (7,) estimated, see `platform_model.PUBLISHED`.
            stationary: (7, 7) covariance stated.
        """
        news = None
        variances = stationary.diagonal().tolist()
        for name, error, variance in zip(PUBLISHED, errors.tolist(), variances, strict=True):
            sigma = math.sqrt(variance)
            apart = abs(error) / max(sigma, 1e-12)
            if self._incredible and apart < SURE_SIGMAS:
                self._incredible.pop(name, None)
            if not apart > TUNING.platform_sigmas:
                continue
            self._incredible[name] = _incredible(name, error, sigma)
            if name not in self._told and news is None:
                self._told.add(name)
                news = WarningText(self._incredible[name])
        return news


def _misfit(ratio: float, level: float) -> str:
    consequence = "positions are less certain than published"
    if level > 1.0:
        consequence = f"their noise is assumed {math.sqrt(level):.1f} times the stated one"
    return (
        f"Boxes are {math.sqrt(ratio):.1f} times as far from their predictions as the stated "
        f"noise allows: {consequence}. Check the noise.* parameters, camera.latency_s and the "
        "compass."
    )


def _turned(sigma: float) -> str:
    return (
        "All robots in view started to move together, or are where no robots can be, as if the "
        f"camera had rotated by {math.degrees(sigma):.0f} deg or more: published covariances "
        "contain that. Check the gimbal and the compass."
    )


def _incredible(name: str, error: float, sigma: float) -> str:
    words, parameter, scale, unit = _WORDS[name]
    # No flight calibrates a receiver.
    remedy = "it may have jumped; else" if name.startswith("gnss") else "calibrate it or"
    return (
        f"The {words} seems to need a correction of {scale * error:+.2g} {unit}, which is "
        f"{abs(error) / sigma:.1f} times the stated sigma ({parameter}): {remedy} state a larger "
        "one."
    )


def _quick(seconds: float) -> str:
    return (
        f"Errors of the compass, the gimbal or the height change within about {seconds:g} s: "
        "noise.correlation_time_s or camera.latency_s may be wrong."
    )
