# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rotation vectors: the axis of a rotation, as long as its angle in rad."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation_matrix(vector: Array) -> Array:
    """Return the rotation (3, 3) about a vector (3,) by its length in rad (Rodrigues)."""
    x, y, z = vector.tolist()
    square = x * x + y * y + z * z
    if square > 1e-6:
        angle = square**0.5
        sine, half = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    else:
        sine, half = 1.0 - square / 6.0, 0.5 - square / 24.0
    cosine = 1.0 - half * square
    return np.array(
        [
            [cosine + half * x * x, half * x * y - sine * z, half * x * z + sine * y],
            [half * x * y + sine * z, cosine + half * y * y, half * y * z - sine * x],
            [half * x * z - sine * y, half * y * z + sine * x, cosine + half * z * z],
        ]
    )


def rotation_vector(matrix: Array) -> Array:
    """Return the rotation vector (3,) in rad of a rotation (3, 3)."""
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    twice = np.array([h - f, c - g, d - b])
    sine = 0.5 * math.hypot(h - f, c - g, d - b)
    cosine = 0.5 * (a + e + i - 1.0)
    if sine > 1e-7:
        return twice * (0.5 * math.atan2(sine, cosine) / sine)
    if cosine > 0.0:
        return 0.5 * twice
    along = matrix + np.eye(3)  # half a turn: every column lies along the axis
    axis: Array = along[:, int(np.argmax(np.diag(along)))]
    return axis * (np.pi / float(np.sqrt(axis @ axis)))
