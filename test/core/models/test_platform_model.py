# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The platform's errors: units, decay, and what is switched off."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.models.platform_model import (
    ANGLES,
    COUNT,
    DEVIATION,
    HEIGHT,
    LATENCY,
    PLATFORM,
    TUNING,
    PlatformModel,
    named_errors,
)

STATED = Noise(
    gnss_offset_m=2.0, height_m=0.5, gimbal_roll_deg=0.3, gimbal_pitch_deg=0.6, heading_deg=1.2,
    latency_s=0.1, correlation_time_s=100.0, gnss_white_m=0.2, height_white_m=0.4,
    gimbal_white_deg=0.5, attitude_white_deg=0.25, box_center_px=3.0,
)  # fmt: skip


def test_each_error_has_its_variance_in_si():
    radians = np.radians([0.3, 0.6, 1.2])
    expected = dict(zip(PLATFORM, [2.0, 2.0, 0.5, *radians, 0.0, 0.0, 0.1], strict=True))
    covariance = PlatformModel(STATED, "earth", exact=True).stationary(None)
    np.testing.assert_allclose(np.sqrt(covariance.diagonal()), list(expected.values()))
    assert np.count_nonzero(covariance) == COUNT - 2
    assert math.sqrt(covariance[HEIGHT, HEIGHT]) == pytest.approx(expected["height"])
    assert math.sqrt(covariance[LATENCY, LATENCY]) == pytest.approx(expected["latency"])
    assert PLATFORM[ANGLES] == ("roll", "pitch", "heading")


def test_height_and_angles_may_be_larger_than_stated_but_drift_no_faster():
    model, stated = PlatformModel(STATED, "earth"), PlatformModel(STATED, "earth", exact=True)
    # Student's t of 5 degrees of freedom has 5 / (5 - 2) times the variance of its Gaussian.
    np.testing.assert_allclose(model.wider, [1.0, 1.0, *[5.0 / 3.0] * 4, 1.0, 1.0, 1.0])
    iron = math.radians(TUNING.deviates * 1.2) ** 2  # no parameter states it
    of_iron = np.diag([*[0.0] * 6, iron, iron, 0.0])
    np.testing.assert_allclose(model.nominal, stated.nominal * model.wider + of_iron)
    np.testing.assert_allclose(model.stated(model.nominal), stated.nominal, atol=1e-15)

    def drift(one: PlatformModel) -> np.ndarray:
        """Variances by which errors change within 0.1 s."""
        return np.delete((1.0 - one.decay(0.1) ** 2) * one.nominal.diagonal(), DEVIATION)

    np.testing.assert_allclose(drift(model), drift(stated), rtol=1e-3)


@pytest.mark.parametrize(
    ("reference", "turn"),
    [
        ("earth", [0.5, 0.5, 0.5]),
        ("heading", [0.5, 0.5, math.hypot(0.5, 0.25)]),
        ("body", [math.hypot(0.5, 0.25)] * 3),
        ("fixed", [0.25] * 3),
    ],
)
def test_white_noise_is_that_of_the_sensors_in_use(reference, turn):
    model = PlatformModel(STATED, reference)
    np.testing.assert_allclose(np.sqrt(model.white), [0.2, 0.2, 0.4, *np.radians(turn)])
    assert model.pixel == 9.0


def test_a_fix_may_bring_its_own_covariance():
    model, own = PlatformModel(STATED, "earth"), np.array([[1.0, 0.5], [0.5, 3.0]])
    found = model.stationary(own)
    np.testing.assert_array_equal(found[:2, :2], own)
    np.testing.assert_array_equal(found[2:, 2:], model.stationary(None)[2:, 2:])
    assert model.stationary(None)[0, 1] == 0.0
    np.testing.assert_array_equal(model.stationary(np.full((2, 2), np.nan)), model.stationary(None))


def test_errors_fade_with_their_correlation_times():
    kept = PlatformModel(STATED, "earth", exact=True).decay(100.0)
    np.testing.assert_allclose(kept[:LATENCY], 1.0 / math.e)
    assert kept[LATENCY] == pytest.approx(math.exp(-100.0 / TUNING.latency_time_s))

    white = PlatformModel(Noise(correlation_time_s=0.0), "earth").decay(0.1)
    assert white[:LATENCY].tolist() == [0.0] * LATENCY
    assert white[LATENCY] == pytest.approx(1.0, abs=1e-4)


def test_errors_that_are_switched_off_are_not_reported():
    variances = np.diag([4.0, 1.0, 0.25, 0.0, 1e-4, 1e-4, 0.0, 0.0, 0.0])
    found = named_errors(np.arange(9.0), variances, np.eye(3))
    assert [one.name for one in found] == ["gnss_east", "gnss_north", "height", "pitch", "heading"]
    assert [(one.value, one.sigma) for one in found][2:4] == [(2.0, 0.5), (4.0, 0.01)]


@pytest.mark.parametrize("azimuth_deg", [0.0, 30.0, 90.0, 200.0])
def test_the_heading_that_is_published_contains_the_deviation(azimuth_deg):
    azimuth = math.radians(azimuth_deg)
    east, north = math.sin(azimuth), math.cos(azimuth)
    axes = np.array([[east, -north, 0.0], [north, east, 0.0], [0.0, 0.0, 1.0]])
    mean = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.01, 0.03, 0.05, 0.2])
    variances = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 0.25, 0.09, 0.16, 0.04])
    found = {one.name: one for one in named_errors(mean, variances, axes)}
    assert len(found) == 7
    assert found["heading"].value == pytest.approx(0.01 + 0.03 * east + 0.05 * north)
    assert found["heading"].sigma ** 2 == pytest.approx(0.25 + 0.09 * east**2 + 0.16 * north**2)
    assert (found["latency"].value, found["latency"].sigma) == pytest.approx((0.2, 0.2))
