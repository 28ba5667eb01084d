# SPDX-License-Identifier: Apache-2.0
"""The camera over the frame `map`: where it should see a robot, and what moves that place.

Everything here is in `map` (East, North, Up on the plane tangent at its origin); the water lies
D²/2R below the plane at a distance D. A ray from the camera along the offset o = (x, y, z), z < 0,
meets the water at the camera's place plus o. To first order a small rotation w of the camera moves
that point by (w × o) less what slides it back along the ray onto the water, o (w × o)_z / z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geodesy import SEMI_MAJOR_M, ecef_of_place, enu_axes
from aerial_gnss_ros.core.gimbal import error_axes
from aerial_gnss_ros.core.local_map import LocalMap
from aerial_gnss_ros.core.values import CameraPose

Array = NDArray[np.float64]

POSE_COUNT = 6
"""Columns of `pose_jacobian`: camera East, North, height; rotation about East, North, Up."""


@dataclass(frozen=True)
class MapPose:
    """A camera in `map`.

    Attributes:
        position: (3,) East, North, Up, m.
        rotation: (3, 3) camera FLU in `map`.
    """

    position: Array
    rotation: Array

    @property
    def optical(self) -> Array:
        """(3, 3) optical frame in `map`."""
        turned: Array = self.rotation @ FLU_FROM_OPTICAL
        return turned

    def corrected(self, errors: Array, axes: Array) -> MapPose:
        """Return the pose with the platform's errors (6,) or more taken out.

        Args:
            errors: East, North, height (m), roll, pitch, heading (rad).
            axes: (3, 3) of the last three, see `gimbal.error_axes`.
        """
        turn = rotation_matrix(axes @ errors[3:6])
        return MapPose(self.position + errors[:3], turn @ self.rotation)


class MapFrame:
    """Brings poses to `map`; made once for one map."""

    def __init__(self, local: LocalMap) -> None:
        self.local = local

    def pose(self, pose: CameraPose) -> MapPose:
        """Return a camera's pose in `map`, which takes the water at its origin's altitude."""
        place = ecef_of_place(pose.latitude, pose.longitude, pose.height)
        axes = self.local.axes
        turn = axes @ enu_axes(pose.latitude, pose.longitude).T
        return MapPose(axes @ (place - self.local.origin), turn @ pose.enu_from_camera)


def level_axes(rotation: Array) -> Array:
    """Return the axes (3, 3) of roll, pitch and heading errors of a camera in `map`."""
    return error_axes(rotation)


def on_water(pose: MapPose, directions: Array) -> Array:
    """Return East, North (n, 2) where rays (n, 3), of any length, meet the water; NaN if not."""
    down = np.where(directions[:, 2] < 0.0, directions[:, 2], np.nan)
    level: Array | float = 0.0
    for _ in range(3):  # the water curves away by millimetres: two steps settle it
        reach = (level - pose.position[2]) / down
        met: Array = pose.position[:2] + directions[:, :2] * reach[:, None]
        level = np.einsum("ij,ij->i", met, met) * (-0.5 / SEMI_MAJOR_M)
    return met


def pose_jacobian(offsets: Array) -> Array:
    """Return (n, 2, 6): how points on the water move with the camera's pose, the pixels fixed.

    Args:
        offsets: (n, 3) from the camera, m.
    """
    jacobian = np.zeros((len(offsets), 2, POSE_COUNT))
    x, y, z = offsets.T
    xz, yz = x / z, y / z
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -xz, -yz
    jacobian[:, 0, 3], jacobian[:, 1, 3] = -xz * y, -z - yz * y
    jacobian[:, 0, 4], jacobian[:, 1, 4] = z + xz * x, xz * y
    jacobian[:, 0, 5], jacobian[:, 1, 5] = -y, x
    return jacobian


def state_jacobian(offsets: Array, velocities: Array) -> Array:
    """Return (n, 4, 6): how places and velocities seem to change with the camera's pose.

    The last two rows are the derivative in time of the first two (`pose_jacobian`): a robot that
    seems 1 % farther seems 1 % faster.

    Args:
        offsets: (n, 3) from the camera, m.
        velocities: (n, 2) on the water, m/s.
    """
    x, y, z = offsets.T
    xz, yz = x / z, y / z
    east, north = velocities.T
    crossed = xz * north + yz * east
    jacobian = np.zeros((len(offsets), 4, POSE_COUNT))
    jacobian[:, :2] = pose_jacobian(offsets)
    jacobian[:, 2, 2], jacobian[:, 3, 2] = -east / z, -north / z
    jacobian[:, 2, 3], jacobian[:, 3, 3] = -crossed, -2.0 * yz * north
    jacobian[:, 2, 4], jacobian[:, 3, 4] = 2.0 * xz * east, crossed
    jacobian[:, 2, 5], jacobian[:, 3, 5] = -north, east
    return jacobian


def pose_by_errors(axes: Array, rates: Array) -> Array:
    """Return (6, 7): how the pose moves with the platform's errors.

    Args:
        axes: (3, 3) of roll, pitch, heading.
        rates: (6,) of the pose: m/s and rad/s. A latency of 1 s more is a pose so much earlier.
    """
    by_errors = np.zeros((POSE_COUNT, 7))
    by_errors[0, 0] = by_errors[1, 1] = by_errors[2, 2] = 1.0
    by_errors[3:, 3:6] = axes
    by_errors[:, 6] = -rates
    return by_errors


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
