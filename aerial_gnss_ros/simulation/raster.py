# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws a placed mesh into a small supersampled layer, split at the water surface."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.planes import F32, U8, Array, shrink
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import ViewPose, Window, project_points

SUBPIXEL_BITS = 6
LAYER_SIZE = 640
"""Supersampled layers are kept below this many samples a side."""


@dataclass(frozen=True)
class Layer:
    """A body as the camera sees it, premultiplied by coverage.

    Attributes:
        window: The pixels that the layer covers; may reach over the image's edge.
        below: (h, w, 3) blue, green, red of the parts under water that get through it.
        hidden: (h, w, 3) share of the water's own glow that those parts hide, per colour.
        above: (h, w, 4) blue, green, red, coverage of the parts over water.
        coverage: (h, w) of both together.
    """

    window: Window
    below: F32
    hidden: F32
    above: F32
    coverage: F32


def body_window(camera: CameraModel, pose: ViewPose, mesh: Mesh, margin: int = 2) -> Window | None:
    """Pixels that a mesh may touch; None if it is out of view."""
    pixels, valid = project_points(camera, pose, mesh.vertices)
    if not valid.all():
        return None
    low = np.floor(pixels.min(axis=0)).astype(int) - margin
    high = np.ceil(pixels.max(axis=0)).astype(int) + margin
    window = Window(int(low[0]), int(low[1]), int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1)
    if max(window.width, window.height) > 4 * max(camera.width, camera.height):
        return None
    image = Window(0, 0, camera.width, camera.height)
    return window if window.clipped(image) is not None else None


def draw(
    camera: CameraModel,
    pose: ViewPose,
    mesh: Mesh,
    window: Window,
    scene: Scene,
    sun_light: Array,
    sky_light: Array,
) -> Layer:
    """Draws the mesh, nearest faces last.

    Args:
        camera: Of the view.
        pose: Of the view.
        mesh: In local ENU.
        window: Pixels to draw, from `body_window`.
        scene: For the water's colour and attenuation.
        sun_light: (3,) light of the sun on a level sheet.
        sky_light: (3,) light of the sky on it.
    """
    factor = int(np.clip(LAYER_SIZE // max(window.width, window.height), 2, 8))
    shape = (window.height * factor, window.width * factor)
    below, hidden = np.zeros((*shape, 3), np.float32), np.zeros((*shape, 3), np.float32)
    above, cover = np.zeros((*shape, 4), np.float32), np.zeros(shape, np.uint8)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    middles = corners.mean(axis=1)
    views = pose.position - middles
    distances = np.linalg.norm(views, axis=1)
    facing = np.einsum("ij,ij->i", normals, views)
    normals[facing < 0.0] *= -1.0
    order = np.argsort(-(distances - mesh.nearer), kind="stable")
    polygons: list[tuple[Array, Array, Array | None]] = []
    for f in order:
        # Refraction lets the camera see a little more than the straight line does, so faces are
        # culled with some tolerance.
        if not mesh.two_sided[f] and facing[f] < -0.02 * distances[f]:
            continue
        for submerged, polygon in _split(corners[f]):
            light = _face_light(mesh.colours[f], normals[f], scene, sun_light, sky_light, submerged)
            polygons.append((polygon, light, _kept(polygon, scene) if submerged else None))
    if polygons:
        points = np.concatenate([polygon for polygon, _, _ in polygons])
        fixed = _samples(camera, pose, window, factor, points)
        start = 0
        for polygon, light, kept in polygons:
            corner = fixed[start : start + len(polygon)]
            start += len(polygon)
            if kept is None:
                _fill(above, corner, np.append(light, 1.0))
            else:
                _fill(below, corner, light * kept)
                _fill(hidden, corner, kept)
            _fill(cover, corner, np.array([255.0]))
    size = (window.width, window.height)
    covered = cover.astype(np.float32) / 255.0
    return Layer(window, *(shrink(one, size) for one in (below, hidden, above, covered)))


def _samples(
    camera: CameraModel, pose: ViewPose, window: Window, factor: int, points: Array
) -> NDArray[np.int32]:
    """Return the samples (n, 2) of the window where points (n, 3) lie, in OpenCV's fixed point."""
    pixels, _ = project_points(camera, pose, points)
    samples = (pixels - (window.x, window.y) + 0.5) * factor - 0.5
    fixed: NDArray[np.int32] = np.round(samples * 2**SUBPIXEL_BITS).astype(np.int32)
    return fixed


def _fill(buffer: F32 | U8, corners: NDArray[np.int32], colour: Array) -> None:
    cv2.fillConvexPoly(buffer, corners, colour.tolist(), cv2.LINE_8, SUBPIXEL_BITS)


def _split(corners: Array) -> list[tuple[bool, Array]]:
    """Cuts a triangle at z = 0 into (submerged, polygon) parts."""
    z = corners[:, 2]
    if (z >= 0.0).all():
        return [(False, corners)]
    if (z <= 0.0).all():
        return [(True, corners)]
    above: list[Array] = []
    below: list[Array] = []
    for i in range(3):
        a, b = corners[i], corners[(i + 1) % 3]
        (above if a[2] >= 0.0 else below).append(a)
        if (a[2] >= 0.0) != (b[2] >= 0.0):
            cut = a + (b - a) * (a[2] / (a[2] - b[2]))
            above.append(cut)
            below.append(cut)
    return [(True, np.array(below)), (False, np.array(above))]


def _face_light(
    colour: Array,
    normal: Array,
    scene: Scene,
    sun_light: Array,
    sky_light: Array,
    submerged: bool,
) -> Array:
    """Radiance of a face, before the water above it dims it."""
    sun = scene.sun_direction
    height = max(sun[2], 0.15)
    if submerged:
        # Snell bends the sun's rays towards the vertical.
        flat = sun[:2] / 1.34
        sun = np.array([flat[0], flat[1], np.sqrt(1.0 - flat @ flat)])
        height = float(sun[2])
    direct = max(float(normal @ sun), 0.0) / height
    ambient = 0.55 + 0.45 * float(normal[2])
    radiance: Array = colour * (sun_light * min(direct, 1.6) + sky_light * ambient)
    # Radiance falls with the square of the index when it leaves the water.
    return 0.6 * radiance if submerged else radiance


def _kept(polygon: Array, scene: Scene) -> Array:
    """Share per colour that the water lets through: down with the daylight, up to the camera."""
    depth = max(-float(polygon[:, 2].mean()), 0.0)
    share: Array = np.exp(-2.2 * depth * np.array(scene.attenuation))
    return share
