# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Projection of points to the image plane, with the derivative for filters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.distortion import BrownConrady, Equidistant
from aerial_gnss_ros.core.numerics.columns import columns
from aerial_gnss_ros.core.numerics.small_arrays import Rows, evaluate_rows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_BEHIND = 1e-9


def plane_with_jacobian(
    lens: BrownConrady | Equidistant | None, points: Array
) -> tuple[Array, Array, Mask]:
    """Return distorted points (n, 2), their derivative (n, 2, 3), and which are visible (n,).

    Values of invisible points (behind the camera, beyond the model's fold) are meaningless.

    Args:
        lens: None for a pinhole.
        points: (n, 3) in the optical frame.
    """
    if isinstance(lens, Equidistant):
        return _fisheye(lens, points)
    seen: Mask = points[:, 2] > _BEHIND
    if not all(seen.tolist()):  # as if in front of the camera, so that nothing overflows
        points = np.where(seen[:, None], points, [0.0, 0.0, 1.0])
    table = evaluate_rows(
        _pinhole if lens is None else lens.through, points, 8 if lens is None else 10
    )
    if lens is not None:
        seen = seen & (table[:, 8] < lens.max_radius**2) & (table[:, 9] > 0.0)
    return table[:, :2], table[:, 2:8].reshape(-1, 2, 3), seen


def _pinhole(points: Rows) -> list[tuple[Any, ...]]:
    """Return places on the plane, each with its derivative by the point, row by row."""
    found: list[tuple[Any, ...]] = []
    for x, y, z in points:
        inverse = 1.0 / z
        u, v = x * inverse, y * inverse
        found.append((u, v, inverse, 0.0, -u * inverse, 0.0, inverse, -v * inverse))
    return found


def _fisheye(lens: Equidistant, points: Array) -> tuple[Array, Array, Mask]:
    x, y, z = columns(points)
    across = np.hypot(x, y)
    square = np.maximum(across * across + z * z, 1e-18)
    angle = np.arctan2(across, z)
    radius, slope = lens.radius(angle)
    central = across < 1e-9 * np.sqrt(square)
    safe = np.where(central, 1.0, across)
    out = np.where(central[:, None], [1.0, 0.0], points[:, :2] / safe[:, None])
    # radius / across, and its limit on the axis
    scale = np.where(central, 1.0 / np.where(z == 0.0, 1.0, z), radius / safe)
    by_point = np.empty((len(points), 2, 3))
    by_across = slope * z / square  # of the radius
    outer = out[:, :, None] * out[:, None, :]
    by_point[:, :, :2] = by_across[:, None, None] * outer
    by_point[:, :, :2] += scale[:, None, None] * (np.eye(2) - outer)
    by_point[:, :, 2] = -(slope * across / square)[:, None] * out
    seen: Mask = (angle < lens.max_angle) & np.any(points != 0.0, axis=1)
    return points[:, :2] * scale[:, None], by_point, seen
