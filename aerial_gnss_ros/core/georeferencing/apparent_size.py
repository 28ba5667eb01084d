# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Size check: refuses boxes too long or too short for a robot of their class at their distance.

An object of length L on the water extends over at most L across the line of sight, whatever its
heading: its box's longer side is at most L. Within the box no two points of the water are farther
apart than opposite corners: the farther pair of them is at least L apart.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.georeferencing.size_fit import SizeFit
from aerial_gnss_ros.core.numerics.small_arrays import row_products

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SHAPE_SIGMA = 0.2
"""One sigma of a box's extent over the robot's, relative: foam around it, a nose under water, a
detector's margin. Hand-drawn boxes of one buoy in a recorded flight scatter by 0.06 to 0.09."""
WRONG_SIGMAS = 3.0
BORDER_PX = 3.0
"""Distance from the image's border within which a box may be truncated: it can be too long, but not
too short."""


class SizeCheck:
    """Compares boxes with the lengths of robots of their class.

    Args:
        config: `classes.<name>.length_m`; the noise of boxes and height.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        self._lengths = {name: one.length_m for name, one in config.classes if one.length_m}
        self._pixel = config.noise.value("box_center_px")
        self._height = config.noise.value("height_m")

    @property
    def used(self) -> bool:
        """Whether any class has a length."""
        return bool(self._lengths)

    def fit(self, frame: PosedFrame, points: WaterPoints) -> SizeFit:
        """Return how the boxes' sizes compare with the lengths of robots of their class.

        Args:
            frame: the boxes with camera and pose.
            points: positions of their centres on the water; NaN for refused ones.
        """
        boxes = frame.detections
        bounds = np.array([self._lengths.get(name, (0.0, math.inf)) for name in boxes.class_ids])
        sides, diagonals, whole = _extents(frame)
        longer, farthest = points.range_m * sides, points.range_m * diagonals
        with np.errstate(divide="ignore", invalid="ignore"):
            shared, white = self._variances(frame, points)
            excess = np.log(longer / bounds[:, 1])
            shortfall = np.log(bounds[:, 0] / farthest)
        return SizeFit(shortfall, excess, shared, white, whole)

    def _variances(self, frame: PosedFrame, points: WaterPoints) -> tuple[Array, Array]:
        """Return variances (n,) of the logarithm of an extent in metres over the robot's.

        Returns:
            What all boxes of a robot have in common, and what changes from image to image.
        """
        away = points.east_north / np.maximum(np.hypot(*points.east_north.T), 1e-9)[:, None]
        spread = np.einsum("ni,nij,nj->n", away, points.covariance, away)
        level = row_products(points.east_north, points.east_north) / points.range_m**2
        by_range = spread * level / points.range_m**2 + (self._height / frame.pose.height) ** 2
        # A side is the difference of two edges, each as uncertain as a centre's coordinate.
        by_pixel = 2.0 * (self._pixel / np.maximum(frame.detections.sizes.max(axis=1), 1.0)) ** 2
        return SHAPE_SIGMA**2 + by_range, by_pixel


def wrong_size(fit: SizeFit, valid: Mask) -> Mask:
    """Return which boxes (n,) have a wrong size for a robot of their class.

    Args:
        fit: their sizes.
        valid: (n,) whether they have a position on the water.
    """
    most = WRONG_SIGMAS * np.sqrt(fit.shared_variance + fit.white_variance)
    found: Mask = valid & ((fit.excess > most) | ((fit.shortfall > most) & fit.whole))
    return found


def _extents(frame: PosedFrame) -> tuple[Array, Array, Mask]:
    """Return extents of boxes over their range.

    Returns:
        The longer side (n,) across the line of sight, the greatest distance on the water (n,) of
        opposite corners, and which boxes are whole (n,).
    """
    boxes, camera = frame.detections, frame.camera
    size = np.array([camera.width, camera.height], dtype=np.float64)
    low, high = boxes.centers - 0.5 * boxes.sizes, boxes.centers + 0.5 * boxes.sizes
    inside = (low > BORDER_PX) & (high < size - BORDER_PX)
    low, high = np.clip(low, 0.0, size - 1.0), np.clip(high, 0.0, size - 1.0)
    (left, top), (right, bottom) = low.T, high.T
    u, v = np.clip(boxes.centers, 0.0, size - 1.0).T
    ends = [(left, v), (right, v), (u, top), (u, bottom), (left, top), (right, bottom),
            (left, bottom), (right, top), (u, v)]  # fmt: skip
    rays, valid = camera.rays(np.stack([np.stack(one, axis=1) for one in ends]).reshape(-1, 2))
    rays, valid = rays.reshape(9, -1, 3), valid.reshape(9, -1)
    chords = np.where((valid[1:8:2] & valid[:7:2])[..., None], rays[1:8:2] - rays[:7:2], 0.0)
    sides: Array = np.linalg.norm(chords[:2], axis=2).max(axis=0)
    # A chord between corners, moved along the line of sight until both ends are on the water.
    down = -(frame.pose.enu_from_camera @ FLU_FROM_OPTICAL)[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (chords[2:] @ down) / (rays[8] @ down)
        shifted = chords[2:] - along[..., None] * rays[8]
    diagonals: Array = np.linalg.norm(shifted, axis=2).max(axis=0)
    whole: Mask = np.logical_and(inside.all(axis=1), valid.all(axis=0))
    return sides, diagonals, whole
