# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion passes a smoothing spline, errors of telemetry do not."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.calibration.smoothing import PiecewiseSpline, adapted


def test_what_is_motion_and_what_is_error() -> None:
    """A swing of 4 s and 1 m, samples of 0.1 s: its bends exceed 0.01 m of noise from 0.2 s on:
    (0.5 pi 0.2)^4 / 2 is 0.005 m^2, over 0.1 s a sixteenth of that, and the noise's 0.0006."""
    t = 0.1 * np.arange(600)
    swing = np.sin(0.5 * np.pi * t)
    rng = np.random.default_rng(1)
    noisy = swing + 0.3 * rng.normal(size=len(t))
    drifting = np.cumsum(0.3 * np.sqrt(0.1) * rng.normal(size=len(t)))
    table = np.stack([swing, noisy, drifting], axis=1)
    spline, (clear, longer, never) = adapted(t, table, [(0.0, 0.01), (0.0, 0.3), (0.09, 0.0)])
    assert clear == pytest.approx(0.2)
    assert 0.4 <= longer < 1.7
    assert never > 3.0  # nothing but the drift that is stated
    off = spline(t)[50:-50] - swing[50:-50, None]
    assert np.std(off[:, 0]) < 0.01
    assert np.std(off[:, 1]) < 0.25  # 0.3 of noise, and a part of the swing
    assert np.std(np.diff(off[:, 1])) < 0.05  # what a fit would take for motion; 0.42 before


def test_no_value_within_a_gap() -> None:
    t = np.concatenate([np.arange(0.0, 3.0, 0.1), np.arange(6.0, 9.0, 0.1), [20.0, 20.1]])
    found = PiecewiseSpline(
        t, t[:, None] ** 2, 1.0, lambda at, values: adapted(at, values, [(0.0, 1e-6)])[0]
    )
    at = np.array([1.0, 4.0, 7.0, 20.05])
    values, rates, known = found.at(at)
    assert known.tolist() == [True, False, True, False]  # two samples make no piece
    np.testing.assert_allclose(values[known, 0], at[known] ** 2, atol=0.02)
    np.testing.assert_allclose(rates[known, 0], 2.0 * at[known], atol=0.1)
