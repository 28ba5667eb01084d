# SPDX-License-Identifier: Apache-2.0
"""Camera geometry for rendering: rays of a pixel window, and pixels of points seen through water."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.errors import ConfigError
from aerial_gnss_ros.core.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.simulation.refraction import apparent_points

Array = NDArray[np.float64]
F32 = NDArray[np.float32]
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
        """(3, 3)"""
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


def optical_rays(camera: CameraModel, window: Window) -> F32:
    """Unit rays (height, width, 3) in the optical frame through the centres of a window's pixels.

    Centres have whole coordinates, as in OpenCV. Where the lens model has no inverse the nearest
    ray that has one stands in.
    """
    u, extra_u = _nodes(window.x, window.width, camera.width)
    v, extra_v = _nodes(window.y, window.height, camera.height)
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays, valid = camera.rays(grid)
    if not valid.all():
        rays = _filled(rays, valid, grid)
    coarse = rays.reshape(len(v), len(u), 3)
    coarse = _continued(_continued(coarse, extra_v).swapaxes(0, 1), extra_u).swapaxes(0, 1)
    coarse = np.ascontiguousarray(coarse, dtype=np.float32)
    x = np.arange(window.width, dtype=np.float32) / GRID + 1.0
    y = np.arange(window.height, dtype=np.float32) / GRID + 1.0
    # cv2.remap rounds coordinates to 1/32, which is exact for an eighth.
    mx, my = np.meshgrid(x, y)
    fine: F32 = cv2.remap(coarse, mx, my, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    fine /= np.linalg.norm(fine, axis=-1, keepdims=True)
    return fine


def _nodes(start: int, length: int, limit: int) -> tuple[Array, int]:
    """Pixels of the grid that lie in the image, and how many more the interpolation needs."""
    count = -(-(length - 1) // GRID) + 2
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
    return pixels, np.isfinite(pixels).all(axis=1)
