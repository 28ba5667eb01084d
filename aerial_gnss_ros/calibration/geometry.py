# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Projects robots into images, given poses and their errors; with derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.motion import Poses
from aerial_gnss_ros.calibration.pose_errors import error_axes_of
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, skew
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.geometry.refraction import submerged_offsets

Array = NDArray[np.float64]
Index = NDArray[np.intp]

HORIZON = -0.02
"""Rays less steep than this (down per length) count as missing the water."""


@dataclass(frozen=True)
class Boxes:
    """Boxes of some images, one row each.

    Attributes:
        images: (n,) their numbers, not decreasing.
        pixels: (n, 2) centres.
        rays: (n, 3) unit directions in the optical frame; NaN where the camera has none.
        depths: (n,) of the robots below the surface, m.
        kinds: (n,) numbers of the class names.
        cameras: camera models, each with its rows (k,).
    """

    images: Index
    pixels: Array
    rays: Array
    depths: Array
    kinds: Index
    cameras: tuple[tuple[CameraModel, Index], ...]

    def only(self, rows: Index) -> Boxes:
        """Return some of the boxes, in their order."""
        number = np.full(len(self.images), -1)
        number[rows] = np.arange(len(rows))
        cameras = tuple((camera, number[own][number[own] >= 0]) for camera, own in self.cameras)
        return Boxes(
            self.images[rows], self.pixels[rows], self.rays[rows], self.depths[rows],
            self.kinds[rows], tuple(one for one in cameras if len(one[1])),
        )  # fmt: skip


@dataclass(frozen=True)
class Predicted:
    """The model's prediction of boxes.

    Attributes:
        values: (n, 2) measured less predicted, px; NaN where the model does not see the robot.
        by_place: (n, 2, 2) derivative of the prediction by the robot's East, North position.
        by_error: (n, 2, 6) by the pose's errors.
        by_latency: (n, 2) px/s, with all telemetry taken earlier.
        by_fix_delay: (n, 2) px/s, with only the camera's positions taken later.
        by_focal: (n, 2) by the logarithm of the focal length.
        area: (n,) logarithm of the px² that 1 m² covers, less a constant of the pixel.
        area_by_error: (n, 6) its derivative at a fixed pixel.
    """

    values: Array
    by_place: Array
    by_error: Array
    by_latency: Array
    by_fix_delay: Array
    by_focal: Array
    area: Array
    area_by_error: Array


def predicted(boxes: Boxes, poses: Poses, errors: Array, places: Array, focal: float) -> Predicted:
    """Return the prediction of boxes.

    Args:
        boxes: n.
        poses: of the images (m,).
        errors: (n, 6) of the pose at each box, see ERRORS.
        places: (n, 2) East, North of the robots, m.
        focal: logarithm of true focal length / stated one.
    """
    at = boxes.images
    rotation = poses.rotation[at]
    axes = error_axes_of(rotation)
    turn = Rotation.from_rotvec(np.einsum("nij,nj->ni", axes, errors[:, 3:])).as_matrix()
    optical = turn @ rotation @ FLU_FROM_OPTICAL
    offsets = on_water_surface(places) - poses.position[at] - errors[:, :3]
    if boxes.depths.any():
        offsets = _surface(offsets, boxes.depths)
    pixels, by_offset, by_focal, seen = _projected(boxes, offsets, optical, focal)
    by_turn = by_offset @ skew(
        offsets
    )  # rotating the camera by w moves points in it by -w x offset
    by_turning = (by_turn @ poses.turning[at][:, :, None])[:, :, 0]
    by_motion = (by_offset @ poses.velocity[at][:, :, None])[:, :, 0]
    values = boxes.pixels - pixels
    values[~(seen & (offsets[:, 2] < 0.0) & poses.known[at])] = np.nan
    by_error = np.concatenate([-by_offset, by_turn @ axes], axis=2)
    area, area_by_error = _areas(offsets, axes)
    return Predicted(
        values, by_offset[:, :, :2], by_error, by_motion - by_turning, -by_motion, by_focal, area,
        area_by_error,
    )  # fmt: skip


def on_water(boxes: Boxes, poses: Poses) -> tuple[Array, Array]:
    """Return positions on the water (n, 2), NaN if above the horizon, and distances (n,)."""
    optical = poses.rotation[boxes.images] @ FLU_FROM_OPTICAL
    rays = np.einsum("nij,nj->ni", optical, boxes.rays)
    height = poses.position[boxes.images, 2]
    good = (rays[:, 2] < HORIZON) & (height > 0.0) & poses.known[boxes.images]
    reach = np.where(good, height / np.where(good, -rays[:, 2], 1.0), np.nan)
    places = poses.position[boxes.images, :2] + reach[:, None] * rays[:, :2]
    if boxes.depths.any():
        places[good] += submerged_offsets(rays[good], boxes.depths[good])[0]
    return places, reach


def _areas(offsets: Array, axes: Array) -> tuple[Array, Array]:
    """Return logarithms of areas (n,) and their derivatives (n, 6) by errors at fixed pixels.

    A ray at an angle d below the horizon from the height h has the length h / sin d. The area of a
    pixel grows with its square, and with 1 / sin d because the water is seen obliquely.
    """
    rays = offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
    down = np.maximum(-rays[:, 2], 0.02)
    height = np.maximum(-offsets[:, 2], 0.1)
    by_error = np.zeros((len(offsets), 6))
    by_error[:, 2] = -2.0 / height
    lowered = -np.cross(axes, rays[:, :, None], axis=1)[:, 2, :]
    by_error[:, 3:] = 3.0 * lowered / down[:, None]
    return 3.0 * np.log(down) - 2.0 * np.log(height), by_error


def _surface(offsets: Array, depths: Array) -> Array:
    """Return the offsets (n, 3) of the points on the surface at which robots are seen."""
    seen = offsets.copy()
    for _ in range(3):
        rays = seen / np.linalg.norm(seen, axis=1, keepdims=True)
        seen[:, :2] = offsets[:, :2] - submerged_offsets(rays, depths)[0]
    return seen


def _projected(
    boxes: Boxes, offsets: Array, optical: Array, focal: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return pixels (n, 2), derivatives by offset (n, 2, 3) and focal length, and visibility."""
    pixels, by_focal = np.zeros((2, len(offsets), 2))
    by_offset = np.zeros((len(offsets), 2, 3))
    seen = np.zeros(len(offsets), dtype=np.bool_)
    scale = float(np.exp(focal))
    for camera, rows in boxes.cameras:
        turned = optical[rows]
        points = np.einsum("nj,njk->nk", offsets[rows], turned)
        found, by_point, seen[rows] = camera.project_with_jacobian(points)
        middle = camera.K[:2, 2]
        by_focal[rows] = scale * (found - middle)
        pixels[rows] = middle + by_focal[rows]
        by_offset[rows] = scale * by_point @ turned.swapaxes(1, 2)
    return pixels, by_offset, by_focal, seen
