# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Apparent position of a submerged point: Snell crossing of a flat water surface at z = 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geometry.refraction import WATER_INDEX


def apparent_points(
    camera_position: ArrayLike, points: ArrayLike, index: float = WATER_INDEX
) -> NDArray[np.float64]:
    """Replaces submerged points by the point of the surface through which the camera sees them.

    The light's path lies in the vertical plane through camera and point. With horizontal distance
    r, camera height h and depth d the crossing at x solves
    x / sqrt(x² + h²) = index (r - x) / sqrt((r - x)² + d²),
    whose left side minus right side grows monotonically in x.

    Args:
        camera_position: (3,) m, ENU with z = 0 on the water, above the water.
        points: (n, 3) m in the same frame.
        index: Refractive index of the water.

    Returns:
        (n, 3): points at or above the surface unchanged; submerged ones at their crossing (z = 0).
    """
    camera = np.asarray(camera_position, dtype=np.float64)
    result = np.array(points, dtype=np.float64, copy=True)
    below = result[:, 2] < 0.0
    if not below.any():
        return result
    offset = result[below, :2] - camera[:2]
    r = np.hypot(offset[:, 0], offset[:, 1])
    h, d = camera[2], -result[below, 2]
    # No ray in the water is flatter than the limit of total reflection.
    low, high = np.maximum(r - d / np.sqrt(index**2 - 1.0), 0.0), r.copy()
    x = 0.5 * (low + high)
    for _ in range(12):  # Newton's method, halving the bracket where it would leave it
        in_air, in_water = np.hypot(x, h), np.hypot(r - x, d)
        excess = x / in_air - index * (r - x) / in_water
        low, high = np.where(excess < 0.0, x, low), np.where(excess < 0.0, high, x)
        step = x - excess / (h**2 / in_air**3 + index * d**2 / in_water**3)
        x = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
    share = np.divide(x, r, out=np.zeros_like(r), where=r > 0.0)
    result[below, :2] = camera[:2] + offset * share[:, None]
    result[below, 2] = 0.0
    return result
