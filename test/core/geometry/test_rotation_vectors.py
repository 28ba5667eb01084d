# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rotation vectors against scipy, at no and at half a turn too."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix, rotation_vector

part = st.floats(-1.0, 1.0)
axes = st.tuples(part, part, part).filter(lambda one: np.linalg.norm(one) > 1e-3)
angles = st.one_of(st.floats(0.0, math.pi), st.sampled_from([0.0, 1e-9, 1e-4, 9e-4, 1.1e-3]))


@given(axes, angles)
def test_matrices_are_those_of_scipy(axis, angle):
    vector = angle * np.array(axis) / np.linalg.norm(axis)
    matrix = rotation_matrix(vector)
    np.testing.assert_allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-14)
    back = rotation_vector(matrix)
    if angle < math.pi - 1e-6:
        np.testing.assert_allclose(back, vector, atol=1e-9)
    assert np.linalg.norm(back) == pytest.approx(angle, abs=1e-7)


@pytest.mark.parametrize(
    "axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, -0.8), (0.0, 0.6, 0.8)]
)
def test_half_a_turn_goes_either_way(axis):
    vector = rotation_vector(rotation_matrix(math.pi * np.array(axis)))
    np.testing.assert_allclose(np.abs(vector), math.pi * np.abs(axis), atol=1e-7)
    np.testing.assert_allclose(np.cross(vector, axis), 0.0, atol=1e-7)
