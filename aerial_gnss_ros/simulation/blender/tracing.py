# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outline of each robot: lines of sight, refracted at the rendered waves, traced to its mesh.

Cycles' object index shows the water, not objects under it, so labels are traced here; a test
compares them with a Cycles rendering of glowing robots through clear water.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.refraction import WATER_INDEX
from aerial_gnss_ros.simulation.blender.rig import world_triangles
from aerial_gnss_ros.simulation.blender.studio import Set
from aerial_gnss_ros.simulation.view import Window, project_points

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
LINES = 120
"""Lines of sight along the longer side of a robot's surroundings, at most four per pixel."""


@dataclass(frozen=True)
class Outline:
    """Apparent outline of one robot.

    Attributes:
        pixels: (n, 2) of sight lines that meet it, whole image, OpenCV's convention; also beside
            the window.
        step: px between sight lines.
        free: (n,) whether nothing else is before it.
    """

    pixels: Array
    step: float
    free: Mask


class Tracer:
    """Follows sight lines of one set."""

    def __init__(self, built: Set) -> None:
        self._view = built.shot.view
        self._sea = _Surface([built.sea])
        self._robots = {name: _Surface(things) for name, things in built.robots.items()}
        self._props = [_Surface([thing]) for thing in built.props]

    def outline(self, name: str) -> Outline | None:
        """Return a robot's outline, None if it is not visible."""
        robot = self._robots[name]
        area = self._surroundings(robot)
        if area is None:
            return None
        low, high = area
        step = max(0.5, float((high - low).max()) / LINES)
        u = np.arange(low[0], high[0] + step, step)
        v = np.arange(low[1], high[1] + step, step)
        pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        lines = self._lines(pixels)
        reached = lines.distance_to(robot)
        met = np.isfinite(reached)
        if not met.any():
            return None
        free = np.ones(len(pixels), dtype=np.bool_)
        for other in [s for n, s in self._robots.items() if n != name] + self._props:
            if self._near(other, low, high):
                free &= lines.distance_to(other) > reached
        return Outline(pixels[met], step, free[met])

    def _surroundings(self, robot: _Surface) -> tuple[Array, Array] | None:
        """Bounds of the robot in px: refracted at level water, with a margin."""
        bounds = self._bounds(robot)
        if bounds is None:
            return None
        window = self._view.window
        # A little beyond the window: a robot's truncated share is part of its label.
        edge, size = _corner_and_size(window)
        low = np.maximum(bounds[0], edge - 0.5 * size)
        high = np.minimum(bounds[1], edge + 1.5 * size)
        return (low, high) if (high > low).all() else None

    def _bounds(self, thing: _Surface) -> tuple[Array, Array] | None:
        direct, valid = project_points(self._view.camera, self._view.pose, thing.points)
        if not valid.all():
            return None
        level = thing.points - [0.0, 0.0, max(float(thing.points[:, 2].max()), 0.0)]
        bent, _ = project_points(self._view.camera, self._view.pose, level)
        both = np.concatenate([direct, bent])
        margin = 4.0 + 0.25 * (direct.max(axis=0) - direct.min(axis=0)).max()
        return both.min(axis=0) - margin, both.max(axis=0) + margin

    def _near(self, thing: _Surface, low: Array, high: Array) -> bool:
        bounds = self._bounds(thing)
        return bounds is None or bool((bounds[0] < high).all() and (bounds[1] > low).all())

    def _lines(self, pixels: Array) -> _Lines:
        view = self._view
        k = view.camera.K
        optical = np.column_stack([(pixels - k[:2, 2]) / k[[0, 1], [0, 1]], np.ones(len(pixels))])
        rays = optical @ view.pose.enu_from_optical.T
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        start = np.broadcast_to(view.pose.position, rays.shape)
        depth, face = self._sea.cast(start, rays)
        wet = np.isfinite(depth)
        crossing = start + rays * np.where(wet, depth, 0.0)[:, None]
        normal = self._sea.normals(face, crossing)
        return _Lines(start, rays, depth, crossing, refracted(rays, normal))


@dataclass(frozen=True)
class _Lines:
    """Sight lines: start and direction in air, length to the water, then direction in it."""

    start: Array
    rays: Array
    depth: Array
    crossing: Array
    bent: Array

    def distance_to(self, thing: _Surface) -> Array:
        """Length of the path to an object through air, then water; infinite if it is not hit."""
        result, _ = thing.cast(self.start, self.rays)
        result = np.where(result < self.depth, result, np.inf)
        rest = ~np.isfinite(result) & np.isfinite(self.depth)
        if rest.any():
            below, _ = thing.cast(self.crossing[rest] + 1e-5 * self.bent[rest], self.bent[rest])
            result[rest] = self.depth[rest] + below
        return result


def refracted(rays: Array, normals: Array) -> Array:
    """Directions (n, 3) in the water of unit rays from the air, by Snell's law.

    Args:
        rays: (n, 3) unit, downward.
        normals: (n, 3) unit, of the surface, upward.
    """
    cosine = -np.einsum("ij,ij->i", rays, normals)
    ratio = 1.0 / WATER_INDEX
    inside = np.sqrt(np.maximum(1.0 - ratio**2 * (1.0 - cosine**2), 0.0))
    bent: Array = ratio * rays + (ratio * cosine - inside)[:, None] * normals
    return bent


class _Surface:
    """Triangles that rays can hit."""

    def __init__(self, things: list[Any]) -> None:
        from mathutils.bvhtree import BVHTree

        self.points, self._faces = world_triangles(things)
        self._tree = BVHTree.FromPolygons(self.points.tolist(), self._faces.tolist())
        self._vertex_normals: Array | None = None

    def cast(self, start: Array, rays: Array) -> tuple[Array, NDArray[np.int64]]:
        """Distances (n,) to the first triangle met, infinite if none, and its index or -1."""
        distance = np.full(len(rays), np.inf)
        face = np.full(len(rays), -1, dtype=np.int64)
        cast = self._tree.ray_cast
        for i, (point, ray) in enumerate(zip(start.tolist(), rays.tolist(), strict=True)):
            _, _, index, length = cast(point, ray)
            if index is not None:
                distance[i], face[i] = length, index
        return distance, face

    def normals(self, faces: NDArray[np.int64], points: Array) -> Array:
        """Smooth normals (n, 3) at points of faces, as a smoothly shaded mesh has them."""
        if self._vertex_normals is None:
            corner = self.points[self._faces]
            normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
            summed = np.zeros_like(self.points)
            for i in range(3):
                np.add.at(summed, self._faces[:, i], normal)
            self._vertex_normals = summed / np.linalg.norm(summed, axis=1, keepdims=True)
        chosen = self._faces[np.maximum(faces, 0)]
        a, b, c = (self.points[chosen[:, i]] for i in range(3))
        whole = np.cross(b - a, c - a)
        area = np.einsum("ij,ij->i", whole, whole)
        wb = np.einsum("ij,ij->i", np.cross(points - a, c - a), whole) / area
        wc = np.einsum("ij,ij->i", np.cross(b - a, points - a), whole) / area
        weights = np.clip(np.stack([1.0 - wb - wc, wb, wc], axis=-1), 0.0, 1.0)
        mixed = np.einsum("ni,nij->nj", weights, self._vertex_normals[chosen])
        unit: Array = mixed / np.linalg.norm(mixed, axis=1, keepdims=True)
        return unit


def box(outline: Outline, window: Window) -> tuple[float, float, float, float] | None:
    """Left, top, right, bottom of the part in the window, px; None if empty."""
    inside = in_window(outline.pixels, window)
    if not inside.any():
        return None
    half = 0.5 * outline.step
    low = outline.pixels[inside].min(axis=0) - half
    high = outline.pixels[inside].max(axis=0) + half
    edge, size = _corner_and_size(window)
    low, high = np.maximum(low, edge), np.minimum(high, edge + size)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def in_window(pixels: Array, window: Window) -> Mask:
    """Which pixels (n, 2) lie in a window."""
    edge, size = _corner_and_size(window)
    local = pixels - edge
    inside: Mask = np.all((local >= 0.0) & (local < size), axis=1)
    return inside


def _corner_and_size(window: Window) -> tuple[Array, Array]:
    """Left upper edge and size of a window, px; its first pixel's centre is half a pixel in."""
    corner = np.array([window.x - 0.5, window.y - 0.5])
    return corner, np.array([window.width, window.height], dtype=np.float64)
