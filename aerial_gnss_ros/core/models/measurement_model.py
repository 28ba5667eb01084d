# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measurement model in the frame `map`: positions on the water, and their derivatives.

Everything here is in `map` (East, North, Up on the plane tangent at its origin); the water lies
D²/2R below the plane at a distance D. A ray from the camera along the offset o = (x, y, z), z < 0,
meets the water at the camera's position plus o. To first order a small rotation w of the camera
moves that point by w × o, minus o (w × o)_z / z, which slides it back along the ray onto the water.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.geodesy import SEMI_MAJOR_M
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, DEVIATION, LATENCY
from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS, Rows, rowwise

Array = NDArray[np.float64]

POSE_COUNT = 6
"""Columns of `pose_jacobian`: camera East, North, height; rotation about East, North, Up."""


def level_axes(rotation: Array) -> Array:
    """Return the axes (3, 3) of roll, pitch and heading errors of a camera in `map`."""
    return error_axes(rotation)


def on_water(pose: MapPose, directions: Array) -> Array:
    """Return East, North (n, 2) where rays (n, 3), of any length, meet the water; NaN if not."""
    place = pose.position.tolist()
    if len(directions) <= MAX_ROWS:
        return np.array(_met(place, directions.tolist())).reshape(-1, 2)
    x, y, z = directions.T
    return np.stack(_met(place, [(x, y, np.where(z < 0.0, z, np.nan))])[0], axis=1)


def _met(place: list[float], rays: Rows) -> list[tuple[Any, Any]]:
    """Return where downward rays from a position meet the water, for numbers or arrays (n,)."""
    found: list[tuple[Any, Any]] = []
    for x, y, z in rays:
        if isinstance(z, float) and not z < 0.0:
            found.append((math.nan, math.nan))
            continue
        reach = -place[2] / z
        for _ in range(2):  # the water curves away by millimetres: two steps settle it
            east, north = place[0] + x * reach, place[1] + y * reach
            reach = ((east * east + north * north) * (-0.5 / SEMI_MAJOR_M) - place[2]) / z
        found.append((place[0] + x * reach, place[1] + y * reach))
    return found


@rowwise(2, POSE_COUNT)
def pose_jacobian(offsets: Rows) -> list[tuple[Any, ...]]:
    """Return derivatives (n, 2, 6) of points on the water by the camera's pose at fixed pixels.

    Args:
        offsets: (n, 3) from the camera, m.
    """
    found: list[tuple[Any, ...]] = []
    for x, y, z in offsets:
        xz, yz = x / z, y / z
        found.append((
            1.0, 0.0, -xz, -xz * y, z + xz * x, -y,
            0.0, 1.0, -yz, -z - yz * y, xz * y, x,
        ))  # fmt: skip
    return found


@rowwise(4, POSE_COUNT)
def state_jacobian(states: Rows) -> list[tuple[Any, ...]]:
    """Return derivatives (n, 4, 6) of apparent positions and velocities by the camera's pose.

    The last two rows are the derivative in time of the first two (`pose_jacobian`): a robot that
    seems 1 % farther seems 1 % faster.

    Args:
        states: (n, 5) offset from the camera, m, and East, North of the velocity, m/s.
    """
    found: list[tuple[Any, ...]] = []
    for x, y, z, east, north in states:
        xz, yz = x / z, y / z
        crossed = xz * north + yz * east
        found.append((
            1.0, 0.0, -xz, -xz * y, z + xz * x, -y,
            0.0, 1.0, -yz, -z - yz * y, xz * y, x,
            0.0, 0.0, -east / z, -crossed, 2.0 * xz * east, -north,
            0.0, 0.0, -north / z, -2.0 * yz * north, crossed, east,
        ))  # fmt: skip
    return found


def pose_by_errors(axes: Array, rates: Array) -> Array:
    """Return the derivatives (6, 9) of the pose by the platform's errors.

    Args:
        axes: (3, 3) of roll, pitch, heading.
        rates: (6,) of the pose: m/s and rad/s. A latency of 1 s more means a pose 1 s earlier.
    """
    by_errors = np.zeros((POSE_COUNT, COUNT))
    by_errors[0, 0] = by_errors[1, 1] = by_errors[2, 2] = 1.0
    by_errors[3:, ANGLES] = axes
    by_errors[5, DEVIATION] = axes[:2, 0]
    by_errors[:, LATENCY] = -rates
    return by_errors
