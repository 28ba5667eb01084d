# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What poses err by between samples is large where the motion is fast, and nothing elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.calibration.interpolation import InterpolationError, from_every_other


def test_cubics_are_predicted_exactly() -> None:
    t = np.array([0.0, 1.0, 2.0, 3.1, 4.0, 5.0, 6.0, 7.0, 8.0])
    values = np.stack([t**3, 1.0 - t], axis=1)
    np.testing.assert_allclose(from_every_other(t, values), values, atol=1e-9)


def test_a_sample_does_not_predict_itself() -> None:
    t = np.arange(21.0)
    values = (t == 10.0).astype(float)[:, None]
    found = from_every_other(t, values)
    assert abs(found[10, 0]) < 1e-12
    assert found[11, 0] == pytest.approx(0.6, abs=0.05)  # 9/16 by four points


def test_a_manoeuvre_is_found_at_its_time() -> None:
    """Swings of 3 s between 40 and 60 s, samples a second apart."""
    t = np.arange(100.0)

    def swing(at):
        return (np.sin(2.0 * np.pi * at / 3.0) * (np.abs(at - 50.0) < 10.0))[:, None]

    errors = InterpolationError([0.01])
    errors.add(t, swing(t) - from_every_other(t, swing(t)))
    sigma = np.sqrt(errors.variance(np.array([20.0, 50.3, 80.0]))[:, 0])
    assert 0.3 < sigma[1] < 1.5
    assert sigma[0] == sigma[2] == 0.0


def test_white_noise_is_no_error_of_interpolation() -> None:
    t = 0.1 * np.arange(2000)
    noise = 0.2 * np.random.default_rng(1).normal(size=(len(t), 1))
    errors = InterpolationError([0.2])
    errors.add(t, noise - from_every_other(t, noise))
    assert np.sqrt(np.mean(errors.variance(t))) < 0.35 * 0.2
    unstated = InterpolationError([0.0])
    unstated.add(t, noise - from_every_other(t, noise))
    assert np.sqrt(np.mean(unstated.variance(t))) > 0.5 * 0.2


def test_pieces_are_distinguished_and_nothing_is_known_of_nothing() -> None:
    errors = InterpolationError([0.0])
    np.testing.assert_array_equal(errors.variance(np.zeros(3)), np.zeros((3, 1)))
    errors.add(np.arange(10.0), np.full((10, 1), 2.0))
    errors.add(np.arange(20.0, 30.0), np.full((10, 1), 4.0))
    found = np.sqrt(errors.variance(np.array([5.0, 25.0]))[:, 0])
    assert found[1] == pytest.approx(2.0 * found[0])
