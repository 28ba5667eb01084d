# SPDX-License-Identifier: Apache-2.0
"""From points before a lens to its image plane, with the derivative: what filters linearise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.distortion import BrownConrady, Equidistant

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_BEHIND = 1e-9
_PLANE = np.eye(2)


def plane_with_jacobian(
    lens: BrownConrady | Equidistant | None, points: Array
) -> tuple[Array, Array, Mask]:
    """Return distorted points (n, 2), their derivative (n, 2, 3), and which are seen (n,).

    Values of points that are not seen (behind the camera, beyond the model's fold) mean nothing.

    Args:
        lens: None for a pinhole.
        points: (n, 3) in the optical frame.
    """
    if isinstance(lens, Equidistant):
        return _fisheye(lens, points)
    depth = points[:, 2]
    seen: Mask = depth > _BEHIND
    inverse = 1.0 / (depth if seen.all() else np.where(seen, depth, 1.0))
    plane = points[:, :2] * inverse[:, None]
    by_point = np.empty((len(points), 2, 3))
    by_point[:, :, :2] = _PLANE * inverse[:, None, None]
    by_point[:, :, 2] = plane * -inverse[:, None]
    if lens is None:
        return plane, by_point, seen
    distorted, jacobian = lens.distort(plane)
    return distorted, jacobian @ by_point, seen & lens.monotonic(plane, jacobian)


def _fisheye(lens: Equidistant, points: Array) -> tuple[Array, Array, Mask]:
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
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
