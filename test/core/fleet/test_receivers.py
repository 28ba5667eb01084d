# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Receivers of several drones err in part by the same."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.receivers import common_variance, joint_prior
from aerial_gnss_ros.core.models.platform_model import COUNT


def test_what_a_better_receiver_removed_is_not_common():
    assert common_variance(1.44 * np.eye(2), 4e-4 * np.eye(2), 0.5) == pytest.approx(2e-4)
    assert common_variance(np.diag([1.0, 4.0]), np.diag([9.0, 2.0]), 1.0) == pytest.approx(1.0)


def test_the_common_part_is_a_covariance_of_each_two_drones_on_each_axis():
    each = [np.diag([s, s, 1.0, *[0.1] * 5, 0.0]) for s in (1.44, 4e-4, 4.0)]
    whole = joint_prior(each, 0.5)
    expected = np.zeros((3 * COUNT, 3 * COUNT))
    for k, one in enumerate(each):
        expected[COUNT * k : COUNT * k + COUNT, COUNT * k : COUNT * k + COUNT] = one
    for i, j, common in ((0, 1, 2e-4), (0, 2, 0.72), (1, 2, 2e-4)):
        for axis in (0, 1):
            expected[COUNT * i + axis, COUNT * j + axis] = expected[
                COUNT * j + axis, COUNT * i + axis
            ] = common
    np.testing.assert_allclose(whole, expected)
    assert np.linalg.eigvalsh(joint_prior(each, 1.0)).min() > -1e-12
