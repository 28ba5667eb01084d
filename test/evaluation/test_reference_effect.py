# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A reference corrects from the image in which it halves the variance of most robots."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack
from aerial_gnss_ros.evaluation.reference_effect import while_corrected


def track(sigmas, first_ns=0):
    stamps = first_ns + np.arange(len(sigmas), dtype=np.int64)
    covariance = np.array([sigma**2 * np.eye(2) for sigma in sigmas])
    angles = np.zeros(len(sigmas))
    return EstimatedTrack(stamps, angles, angles, covariance, np.ones(len(sigmas), np.bool_))


@pytest.mark.parametrize(("sigma", "count"), [(0.72, 0), (0.70, 3), (0.1, 3)])
def test_it_halves_the_variance_of_most_robots(sigma, count):
    without = {"a": track([1.0] * 5), "b": track([1.0] * 5)}
    tracks = {"a": track([1.0, 1.0, sigma, sigma, sigma]), "b": track([1.0, sigma, sigma])}
    tracks["c"] = track([1.0, 1.0, sigma])
    kept, share = while_corrected(tracks, without)
    assert kept["a"].stamps_ns.tolist() == [2, 3, 4][:count]
    assert kept["b"].covariance[:, 0, 0].tolist() == [pytest.approx(sigma**2)] * (count // 3)
    assert share == count / 5


def test_only_images_of_both_are_compared():
    assert while_corrected({"a": track([0.1], 7)}, {"a": track([1.0])})[1] == 0.0
    assert while_corrected({}, {}) == ({}, 0.0)
