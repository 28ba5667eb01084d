# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera at each of several candidate latencies: boxes to positions, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.models.measurement_model import pose_jacobian

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

EXPECTED = 2.0
"""Normalised squared distance of a box from where it should be, on average."""


@dataclass(frozen=True)
class Views:
    """The camera for each of h latencies: positions (h, 3) in `map`, optical axes (h, 3, 3).

    Attributes:
        positions, optical: these.
        interpolation: (h, 6) variances of the pose between samples of telemetry, beyond its white
            noise; None: there are none.
    """

    positions: Array
    optical: Array
    interpolation: Array | None = None

    def offsets(self, places: Array) -> Array:
        """Return offsets (h, m, 3) from the cameras to positions (h, m, 2) on the water, m."""
        points = on_water_surface(places.reshape(-1, 2)).reshape(*places.shape[:2], 3)
        return np.asarray(points - self.positions[:, None])

    def places(self, camera: CameraModel, pixels: Array) -> tuple[Array, Mask]:
        """Return positions (h, m, 2) on the water that pixels (m, 2) show, and which do (h, m)."""
        rays, valid = camera.rays(pixels)
        directions = np.einsum("hij,mj->hmi", self.optical, rays)
        down = np.where(directions[..., 2] < 0.0, directions[..., 2], np.nan)
        reach = -self.positions[:, None, 2] / down
        places = self.positions[:, None, :2] + directions[..., :2] * reach[..., None]
        return places, valid & np.isfinite(places).all(axis=2)

    def projected(self, camera: CameraModel, places: Array) -> tuple[Array, Array, Array, Mask]:
        """Return pixels, their derivatives by position and by pose, and visibility.

        Args:
            camera: lens and image.
            places: (h, m, 2) on the water, m.
        """
        shape, offsets = places.shape[:2], self.offsets(places)
        points = np.einsum("hmi,hij->hmj", offsets, self.optical)
        pixels, by_point, seen = camera.project_with_jacobian(points.reshape(-1, 3))
        turned = by_point.reshape(*shape, 2, 3) @ self.optical.swapaxes(1, 2)[:, None]
        by_place = turned[..., :2]
        moved = -by_place @ by_pose(offsets)
        return pixels.reshape(*shape, 2), by_place, moved, seen.reshape(shape)

    def measured(
        self, camera: CameraModel, places: Array, white: Array
    ) -> tuple[Array, Array, Array, Mask]:
        """Return pixels, their derivative by the position, pose noise, and visibility.

        Args:
            camera: lens and image.
            places: (h, m, 2) on the water, m.
            white: (6,) variances of the pose's white noise.
        """
        pixels, by_place, moved, seen = self.projected(camera, places)
        if self.interpolation is not None:
            white = white + self.interpolation[:, None, None]
        noise = (moved * white) @ moved.swapaxes(2, 3)
        return pixels, by_place, noise, seen


def by_pose(offsets: Array) -> Array:
    """Return `pose_jacobian` (h, m, 2, 6) of offsets (h, m, 3)."""
    return pose_jacobian(offsets.reshape(-1, 3)).reshape(*offsets.shape[:2], 2, 6)
