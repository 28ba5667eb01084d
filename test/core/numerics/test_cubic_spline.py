# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Splines on a finer grid, against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from aerial_gnss_ros.core.numerics.cubic_spline import spline_weights


@pytest.mark.parametrize(("count", "parts"), [(4, 1), (4, 20), (5, 3), (61, 20)])
def test_it_is_the_spline_of_scipy(count, parts):
    values = np.random.default_rng(count).normal(size=count)
    fine = np.linspace(0.0, count - 1.0, parts * (count - 1) + 1)
    expected = CubicSpline(np.arange(count), values)(fine)
    np.testing.assert_allclose(spline_weights(count, parts) @ values, expected, atol=1e-12)


def test_a_cubic_is_followed_exactly():
    knots, fine = np.arange(7.0), np.linspace(0.0, 6.0, 61)
    found = spline_weights(7, 10) @ (knots**3 - 2.0 * knots)
    np.testing.assert_allclose(found, fine**3 - 2.0 * fine, atol=1e-11)
