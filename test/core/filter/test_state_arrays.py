# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rows and columns of robots come and go; the others stay as they are."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.models.platform_model import COUNT

sys.path.insert(0, str(Path(__file__).parent))

from three_robots import MODEL, PLACES, crowd


def test_adding_and_dropping_leaves_the_others_as_they_are():
    joint = crowd()
    mean, covariance = joint.mean.copy(), joint.covariance.copy()
    by_platform = np.ones((2, 2, COUNT))
    joint.add(np.array([3, 4]), PLACES[:2], by_platform, np.tile(np.eye(2), (2, 1, 1)), 0.5)
    np.testing.assert_array_equal(joint.covariance[: COUNT + 12, : COUNT + 12], covariance)
    shared = by_platform[0] @ MODEL.stationary(None)
    np.testing.assert_allclose(joint.positions()[2][3], shared)
    expected = shared @ by_platform[0].T + np.eye(2)
    np.testing.assert_allclose(joint.blocks()[3, :2, :2], expected)
    np.testing.assert_allclose(
        joint.covariance[COUNT + 12 : COUNT + 14, COUNT + 16 : COUNT + 18], expected - np.eye(2)
    )
    assert joint.blocks()[4, 2, 2] == pytest.approx(0.25)
    assert np.linalg.eigvalsh(joint.covariance).min() > -1e-12
    joint.drop(np.array([3, 4]))
    np.testing.assert_array_equal(joint.mean, mean)
    np.testing.assert_array_equal(joint.covariance, covariance)
    joint.drop(np.array([0]))
    np.testing.assert_array_equal(joint.rows, [1, 2])
    np.testing.assert_array_equal(joint.robots, mean[COUNT:].reshape(3, 4)[1:])
