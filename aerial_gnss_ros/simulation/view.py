# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera geometry for rendering: rays of a pixel window, pixels of points, through water too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.planes import F32, Array
from aerial_gnss_ros.simulation.refraction import apparent_points

GRID = 8
"""Rays are computed at every eighth pixel and interpolated; lens distortion is smooth."""


@dataclass(frozen=True)
class ViewPose:
    """Where the camera is over the water.

    Attributes:
        position: (3,) m, local ENU, z = 0 on the mean water surface.
        enu_from_camera: (3, 3) camera FLU in ENU.
    """

    position: Array
    enu_from_camera: Array

    @property
    def enu_from_optical(self) -> Array:
        """Camera's optical frame in ENU, (3, 3)."""
        product: Array = self.enu_from_camera @ FLU_FROM_OPTICAL
        return product


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels of the camera's image: left column, top row, width, height."""

    x: int
    y: int
    width: int
    height: int

    def clipped(self, other: Window) -> Window | None:
        """The part inside `other`, or None."""
        x0, y0 = max(self.x, other.x), max(self.y, other.y)
        x1 = min(self.x + self.width, other.x + other.width)
        y1 = min(self.y + self.height, other.y + other.height)
        return Window(x0, y0, x1 - x0, y1 - y0) if x1 > x0 and y1 > y0 else None

    def united(self, other: Window) -> Window:
        """The smallest window round both."""
        x, y = min(self.x, other.x), min(self.y, other.y)
        right = max(self.x + self.width, other.x + other.width)
        bottom = max(self.y + self.height, other.y + other.height)
        return Window(x, y, right - x, bottom - y)


def optical_rays(camera: CameraModel, window: Window) -> F32:
    """Unit rays (height, width, 3) in the optical frame through the centres of a window's pixels.

    Centres have whole coordinates, as in OpenCV. Without an inverse of the lens model, the nearest
    ray with one is used.
    """
    u, extra_u = _nodes(window.x, window.width, camera.width)
    v, extra_v = _nodes(window.y, window.height, camera.height)
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays, valid = camera.rays(grid)
    if not valid.all():
        rays = _filled(rays, valid, grid)
    coarse = rays.reshape(len(v), len(u), 3)
    coarse = _continued(_continued(coarse, extra_v).swapaxes(0, 1), extra_u).swapaxes(0, 1)
    rows = _interpolated(coarse, window.height).astype(np.float32)
    fine: F32 = _interpolated(rows.swapaxes(0, 1), window.width).swapaxes(0, 1)
    return np.ascontiguousarray(fine / np.linalg.norm(fine, axis=-1, keepdims=True))


def _interpolated(nodes: F32, count: int) -> F32:
    """Values at `count` pixels from nodes GRID pixels apart along axis 0, by Catmull and Rom.

    The first node lies one cell before the first pixel. (OpenCV's own bicubic interpolation is
    not exact for straight lines.)
    """
    x = np.arange(count) / GRID
    cell = x.astype(np.int64)
    f = ((x - cell).reshape((-1,) + (1,) * (nodes.ndim - 1))).astype(nodes.dtype)
    a, b, c, d = (nodes[cell + k] for k in range(4))
    result: F32 = b + 0.5 * f * (
        c - a + f * (2.0 * a - 5.0 * b + 4.0 * c - d + f * (3.0 * (b - c) + d - a))
    )
    return result


def _nodes(start: int, length: int, limit: int) -> tuple[Array, int]:
    """Pixels of the grid that lie in the image, and how many more the interpolation needs."""
    count = (length - 1) // GRID + 3
    nodes = start + GRID * np.arange(count, dtype=np.float64)
    inside = nodes[nodes <= limit - 0.5]
    if len(inside) < 3:  # a sliver: one cell, three nodes in it
        raise ConfigError(f"a window of {length} px is too narrow: render at least {2 * GRID + 1}")
    return inside, count - len(inside)


def _continued(nodes: Array, after: int) -> Array:
    """Adds one row before and some after along axis 0 by quadratic extrapolation."""
    rows = [3.0 * nodes[0] - 3.0 * nodes[1] + nodes[2], *nodes]
    for _ in range(after):
        rows.append(3.0 * rows[-1] - 3.0 * rows[-2] + rows[-3])
    return np.stack(rows)


def _filled(rays: Array, valid: NDArray[np.bool_], grid: Array) -> Array:
    rays = rays.copy()
    if not valid.any():
        rays[:] = (0.0, 0.0, 1.0)
        return rays
    good = np.flatnonzero(valid)
    for i in np.flatnonzero(~valid):
        rays[i] = rays[good[np.argmin(((grid[good] - grid[i]) ** 2).sum(axis=1))]]
    return rays


def project_points(
    camera: CameraModel, pose: ViewPose, points: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Pixels (n, 2) at which points (n, 3) in ENU appear, and which of them the lens can see.

    Points under water appear where the refracted path leaves the surface. Points beside the image
    have their pixel too; those behind the camera have none (NaN).
    """
    seen = apparent_points(pose.position, points)
    optical = (seen - pose.position) @ pose.enu_from_optical
    pixels, _ = camera.project(optical)
    in_front: NDArray[np.bool_] = np.isfinite(pixels[:, 0])
    return pixels, in_front
