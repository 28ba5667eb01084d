# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar normal laws against scipy and LAPACK."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2, multivariate_normal

from aerial_gnss_ros.core.numerics.gaussian import gate_threshold, inverse, mahalanobis, within


@pytest.mark.parametrize("probability", [0.5, 0.95, 0.997, 0.999999])
def test_the_gate_is_the_chi_square_quantile(probability):
    assert gate_threshold(probability) == pytest.approx(chi2.ppf(probability, 2), rel=1e-9)


def test_distance_and_determinant_are_those_of_the_normal_law():
    covariance = np.array([[0.5, 0.2], [0.2, 0.9]])
    squared, log_determinant = mahalanobis(np.array([0.3, -0.8]), covariance)
    density = multivariate_normal.logpdf([0.3, -0.8], cov=covariance)
    assert -0.5 * (squared + log_determinant) - np.log(2.0 * np.pi) == pytest.approx(density)


@given(st.floats(0.1, 1e4), st.floats(0.1, 1e4), st.floats(-0.999, 0.999))
def test_an_inverse_is_one_and_exactly_symmetric(a, d, correlation):
    b = correlation * np.sqrt(a * d)
    covariances = np.tile(np.array([[a, b], [b, d]]), (3, 2, 1, 1))
    found = inverse(covariances)
    np.testing.assert_array_equal(found, found.swapaxes(2, 3))
    np.testing.assert_allclose(found, np.linalg.inv(covariances), rtol=1e-9)


def test_a_covariance_that_has_collapsed_divides_by_no_zero():
    squared, _ = mahalanobis(np.array([1.0, -1.0]), np.ones((2, 2)))
    assert np.isfinite(squared)
    assert squared > 1e20


def test_a_part_is_scaled_down_as_far_as_the_whole_needs_and_no_farther():
    whole, small = np.array([[4.0, 1.0], [1.0, 2.0]]), np.array([[1.0, 0.2], [0.2, 0.5]])
    assert within(small, whole) == pytest.approx(small)
    left = whole - within(9.0 * small, whole)
    assert np.linalg.eigvalsh(left) == pytest.approx([0.0, np.trace(left)])
