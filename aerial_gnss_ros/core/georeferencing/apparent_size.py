# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Size check: refuses boxes too long or too short for a robot of their class at their distance.

An object of length L on the water, seen from an angle d below the horizon, extends over at least L
sin d and at most L across the line of sight, whatever its heading. Its box's longer side is at most
L, and its diagonal at least L sin d.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
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
        angles, whole = _angular_extents(frame)
        extents = 2.0 * points.range_m[:, None] * np.sin(0.5 * angles)
        longer, diagonal = extents.max(axis=1), np.hypot(extents[:, 0], extents[:, 1])
        depression = np.minimum(frame.pose.height / points.range_m, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            shared, white = self._variances(frame, points)
            excess = np.log(longer / bounds[:, 1])
            shortfall = np.log(bounds[:, 0] * depression / diagonal)
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


def _angular_extents(frame: PosedFrame) -> tuple[Array, Mask]:
    """Return the angles (n, 2) that widths and heights subtend, and which boxes are whole (n,)."""
    boxes, camera = frame.detections, frame.camera
    size = np.array([camera.width, camera.height], dtype=np.float64)
    low, high = boxes.centers - 0.5 * boxes.sizes, boxes.centers + 0.5 * boxes.sizes
    inside = (low > BORDER_PX) & (high < size - BORDER_PX)
    low, high = np.clip(low, 0.0, size - 1.0), np.clip(high, 0.0, size - 1.0)
    middle = np.clip(boxes.centers, 0.0, size - 1.0)
    ends = np.stack(
        [
            np.stack([low[:, 0], middle[:, 1]], axis=1),
            np.stack([high[:, 0], middle[:, 1]], axis=1),
            np.stack([middle[:, 0], low[:, 1]], axis=1),
            np.stack([middle[:, 0], high[:, 1]], axis=1),
        ]
    )
    rays, valid = camera.rays(ends.reshape(-1, 2))
    rays, valid = rays.reshape(4, -1, 3), valid.reshape(4, -1)
    chords = np.linalg.norm(rays[1::2] - rays[::2], axis=2).T
    chords = np.where((valid[1::2] & valid[::2]).T, chords, 0.0)
    angles: Array = 2.0 * np.arcsin(np.minimum(0.5 * chords, 1.0))
    whole: Mask = np.logical_and(inside.all(axis=1), valid.all(axis=0))
    return angles, whole
