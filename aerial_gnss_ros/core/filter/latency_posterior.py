# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The latency's probability density: before any image, and by what images cost each candidate.

Telemetry that has the stamps of images is most likely late by what that makes it: stamps come late
by up to the time between two images, on average by the square root of 3 of their standard
deviation. A latency that is stated contains that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.latency_evidence import TUNING as LATENCY_EVIDENCE
from aerial_gnss_ros.core.filter.pose_lattice import STEP_S
from aerial_gnss_ros.core.numerics.cubic_spline import spline_weights

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyPosteriorTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    elsewhere: float = 0.1
    """Probability before any image that the latency is none that is expected. Judged."""
    posterior_steps: int = 20
    """Grid points of the posterior between two candidates. Judged."""


TUNING = LatencyPosteriorTuning()

CAUTION = LATENCY_EVIDENCE.caution
"""Divisor of log likelihoods."""


@dataclass(frozen=True)
class LatencyPrior:
    """What is known of a correction of the latency before any image.

    Attributes:
        sigma_s: as configured, s.
        stamp_sigma_s: standard deviation of telemetry's stamps, s, by which no latency is known
            better.
        late_s: how late these stamps are on average, s.
    """

    sigma_s: float
    stamp_sigma_s: float = 0.0
    late_s: float = 0.0

    @classmethod
    def of(cls, sigma_s: float, stamp_sigma_s: float, stated: bool) -> LatencyPrior:
        """Return the prior beside a latency that is stated, or is not."""
        return cls(sigma_s, stamp_sigma_s, 0.0 if stated else math.sqrt(3.0) * stamp_sigma_s)

    def log_density(self, corrections: Array) -> Array:
        """Return the log density (n,) of corrections (n,), s, up to a constant."""
        squared = np.square(corrections / self.sigma_s)
        if not self.stamp_sigma_s:
            return np.asarray(-0.5 * squared)
        near = (corrections + self.late_s) / self.stamp_sigma_s
        anywhere = TUNING.elsewhere * np.exp(-0.5 * squared) / self.sigma_s
        late = (1.0 - TUNING.elsewhere) * np.exp(-0.5 * np.square(near)) / self.stamp_sigma_s
        return np.asarray(np.log(anywhere + late))

    def variance(self, about: float) -> float:
        """Return the mean squared distance from a correction, s²."""
        if not self.stamp_sigma_s:
            return self.sigma_s**2
        late = self.stamp_sigma_s**2 + (about + self.late_s) ** 2
        return TUNING.elsewhere * (self.sigma_s**2 + about**2) + (1.0 - TUNING.elsewhere) * late


def posterior(
    corrections: Array, costs: Array, prior: LatencyPrior, compared: bool
) -> tuple[float, float]:
    """Return mean and sigma of the correction, s.

    Args:
        corrections: (n,) candidates, at least 4, in steps of `STEP_S`.
        costs: (n,) -2 log likelihoods of the images.
        prior: of the correction.
        compared: whether there are any images.
    """
    score = -0.5 * costs / CAUTION + prior.log_density(corrections)
    weights = spline_weights(len(corrections), TUNING.posterior_steps)
    fine: Array = np.linspace(corrections[0], corrections[-1], len(weights))
    values = weights @ score
    weight = np.exp(values - values.max())
    weight /= weight.sum()
    mean = float(weight @ fine)
    wide = prior.variance(mean)
    if not compared:
        return mean, math.sqrt(wide)
    variance = float(weight @ np.square(fine - mean))
    least = prior.stamp_sigma_s**2 + (STEP_S / TUNING.posterior_steps) ** 2
    return mean, math.sqrt(min(variance + least, max(variance, wide)))
