# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Back-projection from the image plane to rays, with the derivative; inverse of `projection`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.distortion import BrownConrady, Equidistant
from aerial_gnss_ros.core.numerics.small_arrays import Rows, evaluate_rows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def pinhole_rays(lens: BrownConrady | None, plane: Array) -> tuple[Array, Array, Mask]:
    """Return unit rays (n, 3), their derivative (n, 3, 2), and which are valid (n,).

    Args:
        lens: None for a pinhole.
        plane: (n, 2) on the normalised image plane.
    """
    if lens is None:
        table = evaluate_rows(_unit_rays, plane, 9)
        valid: Mask = np.ones(len(plane), dtype=np.bool_)
        return table[:, :3], table[:, 3:].reshape(-1, 3, 2), valid
    plane, inverse, valid = lens.undistort(plane)
    table = evaluate_rows(_unit_rays, plane, 9)
    return table[:, :3], table[:, 3:].reshape(-1, 3, 2) @ inverse, valid


def _unit_rays(places: Rows) -> list[tuple[Any, ...]]:
    """Return the unit rays through places on the plane, each with its derivative, row by row."""
    found: list[tuple[Any, ...]] = []
    for x, y in places:
        shorten = (1.0 + x * x + y * y) ** -0.5
        rx, ry = x * shorten, y * shorten
        crossed = -rx * ry * shorten
        found.append((
            rx, ry, shorten,
            (1.0 - rx * rx) * shorten, crossed,
            crossed, (1.0 - ry * ry) * shorten,
            -shorten * rx * shorten, -shorten * ry * shorten,
        ))  # fmt: skip
    return found


def fisheye_rays(lens: Equidistant, plane: Array) -> tuple[Array, Array, Mask]:
    """Return the same as `pinhole_rays` of a fisheye lens."""
    radius = np.hypot(plane[:, 0], plane[:, 1])
    angle, slope, valid = lens.angle(radius)
    central = radius < 1e-12
    outward = np.where(
        central[:, None], [1.0, 0.0], plane / np.where(central, 1.0, radius)[:, None]
    )
    across = np.stack([-outward[:, 1], outward[:, 0]], axis=1)
    sine, cosine = np.sin(angle), np.cos(angle)
    rays = np.column_stack([sine[:, None] * outward, cosine])
    along = (
        np.column_stack([cosine[:, None] * outward, -sine])
        / np.where(slope > 0.0, slope, np.nan)[:, None]
    )
    sideways = np.where(central, 1.0, sine / np.where(central, 1.0, radius))
    jacobian = along[:, :, None] * outward[:, None, :]
    jacobian[:, :2] += sideways[:, None, None] * across[:, :, None] * across[:, None, :]
    return rays, jacobian, valid
