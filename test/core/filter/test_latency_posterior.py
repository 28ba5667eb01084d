# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The latency's density: products of Gaussians, checked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from aerial_gnss_ros.core.filter.latency_posterior import CAUTION, TUNING, LatencyPrior, posterior

CORRECTIONS = np.arange(-30, 31) * 0.1


def parabola(mean, sigma):
    """Return what images cost that tell the latency as a Gaussian, once they are trusted."""
    return CAUTION * np.square((CORRECTIONS - mean) / sigma)


def test_before_any_image_it_is_as_uncertain_as_configured():
    mean, sigma = posterior(CORRECTIONS, 0.0 * CORRECTIONS, LatencyPrior(0.5), compared=False)
    assert mean == pytest.approx(0.0, abs=1e-12)
    assert sigma == 0.5


@pytest.mark.parametrize(("mean", "sigma"), [(0.4, 0.2), (-0.7, 0.15)])
def test_images_and_prior_are_a_product_of_gaussians(mean, sigma):
    found = posterior(CORRECTIONS, parabola(mean, sigma), LatencyPrior(1.0), compared=True)
    variance = 1.0 / (1.0 + sigma**-2)
    step = 0.1 / TUNING.posterior_steps
    assert found[0] == pytest.approx(variance * mean / sigma**2, abs=1e-6)
    assert found[1] == pytest.approx(math.sqrt(variance + step**2), rel=1e-6)


def test_it_is_known_no_better_than_the_stamps_of_telemetry():
    prior = LatencyPrior.of(1.0, 0.2, stated=True)
    _, sigma = posterior(CORRECTIONS, parabola(0.0, 0.05), prior, compared=True)
    assert sigma == pytest.approx(math.hypot(0.2, 0.05), rel=0.05)


def test_images_make_it_no_less_certain_than_the_prior():
    """They say nothing; the grid's step and the stamps' error are in the prior already."""
    found = posterior(CORRECTIONS, 0.0 * CORRECTIONS, LatencyPrior(0.3), compared=True)
    assert found[1] == pytest.approx(0.3, rel=1e-6)


@pytest.mark.parametrize("stated", [False, True])
def test_stamps_of_images_come_late_on_average_unless_a_latency_is_stated(stated):
    """A uniform lateness of 0 to T has the mean T/2 and the standard deviation T/√12."""
    interval_s = 1.0
    prior = LatencyPrior.of(1.0, interval_s / math.sqrt(12.0), stated)
    assert prior.late_s == pytest.approx(0.0 if stated else 0.5 * interval_s)
    density = np.exp(prior.log_density(CORRECTIONS))
    assert CORRECTIONS[np.argmax(density)] == pytest.approx(-prior.late_s, abs=0.05)


def test_its_variance_is_that_of_its_density():
    prior = LatencyPrior.of(1.0, 0.3, stated=False)

    def density(x):
        return math.exp(prior.log_density(np.array([x]))[0])

    total = quad(density, -20.0, 20.0, points=[-prior.late_s], limit=200)[0]
    for about in (0.0, -0.5, 1.3):
        moment = quad(lambda x, a=about: (x - a) ** 2 * density(x), -20.0, 20.0, limit=400)[0]
        assert prior.variance(about) == pytest.approx(moment / total, rel=1e-4)
