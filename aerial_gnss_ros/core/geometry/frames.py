# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames, rotations and signs: the only module that knows NED, FRD, optical axes and headings.

Rotation matrices are `world_from_body`: v_world = R @ v_body. Quaternions are x, y, z, w
(Hamilton). World is ENU, body and camera are FLU (forward, left, up); the optical frame is RDF
(right, down, forward). Yaw 0 is east, counter-clockwise; a compass heading is 0 at north,
clockwise. In FLU a camera that looks straight down has pitch +90 deg.
"""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def _constant(rows: list[list[float]]) -> Array:
    matrix: Array = np.array(rows, dtype=np.float64)
    matrix.setflags(write=False)
    return matrix


ENU_FROM_NED = _constant([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
"""(3, 3); its own inverse."""
FLU_FROM_FRD = _constant([[1, 0, 0], [0, -1, 0], [0, 0, -1]])
"""(3, 3); its own inverse."""
ENU_FROM_NWU = _constant([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
"""(3, 3) Rz(+90 deg)."""
FLU_FROM_OPTICAL = _constant([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
"""(3, 3) camera FLU from camera optical (REP 103)."""


_SKEW = _constant(
    [[0, 0, 0, 0, 0, -1, 0, 1, 0], [0, 0, 1, 0, 0, 0, -1, 0, 0], [0, -1, 0, 1, 0, 0, 0, 0, 0]]
)
"""(3, 9) rows of `skew`, laid flat, by each axis."""

_HALF = math.sqrt(0.5)
_ENU_QUATERNION = {"ned": (_HALF, _HALF, 0.0, 0.0), "nwu": (0.0, 0.0, _HALF, _HALF)}
_FLU_QUATERNION = {"frd": (1.0, 0.0, 0.0, 0.0)}


def wrap_angle(angle: Any) -> Any:
    """Return angles in rad wrapped to [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def heading_from_yaw(yaw: Any) -> Any:
    """Return the compass heading in [0, 2 pi) rad of an ENU yaw in rad."""
    return (0.5 * math.pi - yaw) % (2.0 * math.pi)


def yaw_from_heading(heading: Any) -> Any:
    """Return the ENU yaw in [-pi, pi) rad of a compass heading in rad."""
    return wrap_angle(0.5 * math.pi - heading)


def skew(vector: ArrayLike) -> Array:
    """Return the matrices (..., 3, 3) that form the cross product of vectors (..., 3) with b."""
    v = np.asarray(vector, dtype=np.float64)
    matrices: Array = (v @ _SKEW).reshape(*v.shape, 3)
    return matrices


def matrix_from_quaternion(quaternion: ArrayLike) -> Array:
    """Return rotation matrices (..., 3, 3) of quaternions (..., 4) x, y, z, w.

    They are normalised first; a zero quaternion gives NaN.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    x: Any
    s: Any  # 2 by the square of the length
    if q.ndim == 1:  # in plain numbers, ten times as fast
        x, y, z, w = q.tolist()
        square = x * x + y * y + z * z + w * w
        s = 2.0 / square if square > 0.0 else math.nan
    else:
        norm = np.sum(q * q, axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = 2.0 / np.where(norm > 0.0, norm, np.nan)
        x, y, z, w = np.moveaxis(q, -1, 0)
    rows = np.array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
        ]
    )
    return rows if q.ndim == 1 else np.ascontiguousarray(np.moveaxis(rows, (0, 1), (-2, -1)))


def quaternion_product(a: ArrayLike, b: ArrayLike) -> Array:
    """Return the quaternions (..., 4) x, y, z, w of rotating by `b` first, then by `a`.

    Lengths are multiplied, not normalised: an invalid rotation stays invalid.
    """
    x0, y0, z0, w0 = np.moveaxis(np.asarray(a, dtype=np.float64), -1, 0)
    x1, y1, z1, w1 = np.moveaxis(np.asarray(b, dtype=np.float64), -1, 0)
    return np.stack(
        [
            w0 * x1 + x0 * w1 + y0 * z1 - z0 * y1,
            w0 * y1 - x0 * z1 + y0 * w1 + z0 * x1,
            w0 * z1 + x0 * y1 - y0 * x1 + z0 * w1,
            w0 * w1 - x0 * x1 - y0 * y1 - z0 * z1,
        ],
        axis=-1,
    )


def to_enu_flu(quaternion: Array, world: str, body: str) -> Array:
    """Return the orientation (4,) of FLU axes in ENU from one in other axes.

    Args:
        quaternion: (4,) x, y, z, w of a body's axes in the world's; its length is kept.
        world: `enu`, `ned` or `nwu`.
        body: `flu` or `frd`.
    """
    turned = quaternion
    if world in _ENU_QUATERNION:
        turned = quaternion_product(_ENU_QUATERNION[world], turned)
    if body in _FLU_QUATERNION:  # its own inverse except for the sign, which does not matter
        turned = quaternion_product(turned, _FLU_QUATERNION[body])
    return turned


def to_level_flu(quaternion: Array, body: str) -> Array:
    """Return the orientation (4,) of FLU axes in a vehicle's FLU (or levelled FLU) axes.

    Args:
        quaternion: (4,) x, y, z, w of one in the other, both of the same kind; length is kept.
        body: `flu` or `frd`, of both.
    """
    if body not in _FLU_QUATERNION:
        return quaternion
    turn = _FLU_QUATERNION[body]
    return -quaternion_product(quaternion_product(turn, quaternion), turn)


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Return unit quaternions (..., 4) x, y, z, w with w >= 0 of rotation matrices (..., 3, 3).

    Divides by the largest of the four components (Shepperd 1978), so no rotation loses digits.
    """
    m = np.asarray(matrix, dtype=np.float64)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    # Each row is the quaternion times four times one of its own components.
    rows = np.empty((*m.shape[:-2], 4, 4))
    rows[..., 0, 0] = 1.0 + xx - yy - zz
    rows[..., 1, 1] = 1.0 - xx + yy - zz
    rows[..., 2, 2] = 1.0 - xx - yy + zz
    rows[..., 3, 3] = 1.0 + xx + yy + zz
    rows[..., 0, 1] = rows[..., 1, 0] = m[..., 0, 1] + m[..., 1, 0]
    rows[..., 0, 2] = rows[..., 2, 0] = m[..., 0, 2] + m[..., 2, 0]
    rows[..., 1, 2] = rows[..., 2, 1] = m[..., 1, 2] + m[..., 2, 1]
    rows[..., 0, 3] = rows[..., 3, 0] = m[..., 2, 1] - m[..., 1, 2]
    rows[..., 1, 3] = rows[..., 3, 1] = m[..., 0, 2] - m[..., 2, 0]
    rows[..., 2, 3] = rows[..., 3, 2] = m[..., 1, 0] - m[..., 0, 1]
    best = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(rows, best[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    signed: Array = np.where(q[..., 3:] < 0.0, -q, q)
    return signed


def matrix_from_rpy(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Array:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (..., 3, 3), of angles in rad (ZYX order)."""
    roll, pitch, yaw = np.broadcast_arrays(
        np.asarray(roll, np.float64), np.asarray(pitch, np.float64), np.asarray(yaw, np.float64)
    )
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    cy, sy = np.cos(yaw), np.sin(yaw)
    matrix = np.empty((*roll.shape, 3, 3))
    matrix[..., 0, 0] = cy * cp
    matrix[..., 0, 1] = cy * sp * sr - sy * cr
    matrix[..., 0, 2] = cy * sp * cr + sy * sr
    matrix[..., 1, 0] = sy * cp
    matrix[..., 1, 1] = sy * sp * sr + cy * cr
    matrix[..., 1, 2] = sy * sp * cr - cy * sr
    matrix[..., 2, 0] = -sp
    matrix[..., 2, 1] = cp * sr
    matrix[..., 2, 2] = cp * cr
    return matrix


def rpy_from_matrix(matrix: ArrayLike) -> Array:
    """Return roll, pitch, yaw in rad, (..., 3), of rotation matrices (..., 3, 3).

    Pitch lies within +-pi/2. Exactly up or down, where roll and yaw have the same axis, roll is 0.
    """
    m = np.asarray(matrix, dtype=np.float64)
    level = np.hypot(m[..., 0, 0], m[..., 1, 0])
    pitch = np.arctan2(-m[..., 2, 0], level)
    regular = level > 1e-9
    roll = np.where(regular, np.arctan2(m[..., 2, 1], m[..., 2, 2]), 0.0)
    yaw = np.where(
        regular,
        np.arctan2(m[..., 1, 0], m[..., 0, 0]),
        np.arctan2(-m[..., 0, 1], m[..., 1, 1]),
    )
    return np.stack([roll, pitch, yaw], axis=-1)


def yaw_of(enu_from_flu: ArrayLike) -> float:
    """Return the ENU yaw in rad of where the nose of a body (3, 3) points."""
    m = np.asarray(enu_from_flu, dtype=np.float64)
    return math.atan2(m[1, 0], m[0, 0])


def slerp(q0: ArrayLike, q1: ArrayLike, t: ArrayLike) -> Array:
    """Return the rotation at `t` (0 to 1) on the shorter way from q0 to q1.

    Args:
        q0: (..., 4) x, y, z, w, unit.
        q1: (..., 4) likewise; q and -q are the same rotation.
        t: fraction, scalar or of the leading shape.

    Returns:
        (..., 4) unit quaternions; exactly q0 (normalised) at 0.
    """
    a, b = np.asarray(q0, dtype=np.float64), np.asarray(q1, dtype=np.float64)
    fraction = np.asarray(t, dtype=np.float64)
    if a.ndim == b.ndim == 1 and not fraction.ndim:
        return np.array(_between(a.tolist(), b.tolist(), float(fraction)))
    shape = np.broadcast_shapes(a.shape, b.shape, (*fraction.shape, 4))
    rows = zip(
        np.broadcast_to(a, shape).reshape(-1, 4).tolist(),
        np.broadcast_to(b, shape).reshape(-1, 4).tolist(),
        np.broadcast_to(fraction, shape[:-1]).ravel().tolist(),
        strict=True,
    )
    return np.array([_between(*row) for row in rows]).reshape(shape)


def _between(a: list[float], b: list[float], t: float) -> list[float]:
    """Return the unit quaternion at `t` between two."""
    dot = sum(map(operator.mul, a, b))
    angle = math.acos(min(abs(dot), 1.0))
    wa, wb = 1.0 - t, t
    if angle >= 1e-6:
        sine = math.sin(angle)
        wa, wb = math.sin(wa * angle) / sine, math.sin(wb * angle) / sine
    wb = -wb if dot < 0.0 else wb
    mixed = [wa * one + wb * other for one, other in zip(a, b, strict=True)]
    length = math.hypot(*mixed) or math.nan
    return [part / length for part in mixed]
