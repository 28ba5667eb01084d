# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The water's surface as the camera sees it: the WGS84 ellipsoid raised to the water's level.

The ellipsoid with both half axes longer by the level is not exactly the surface of that altitude
(0.014 mm off at 10 m, 0.14 mm at 100 m), so it is scaled to pass exactly below the camera. Where
the altitude's datum is unknown, the water is placed at ellipsoid height 0; a wrong level of H
metres scales distances from the camera by H / 6.4e6: 0.6 mm at 100 m range for the 40 m between
ellipsoid and sea at Barbados.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import (
    MEAN_RADIUS_M,
    SEMI_MAJOR_M,
    SEMI_MINOR_M,
    ecef_of_places,
    enu_axes,
    geodetic_from_ecef,
)
from aerial_gnss_ros.core.numerics.small_arrays import row_products
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]


class SurfaceView:
    """The water as seen from a camera position. East, North, Up have their origin at the camera.

    Args:
        pose: of the camera; finite, height above 0.

    Attributes:
        water_altitude: of the water above the ellipsoid as used in the computation, m.
        enu_from_optical: (3, 3) camera optical frame in ENU.
        dip: angle of the water's horizon below the horizontal, rad.
    """

    def __init__(self, pose: CameraPose) -> None:
        known = not math.isnan(pose.altitude)
        self.water_altitude = pose.altitude - pose.height if known else 0.0
        self._axes = enu_axes(pose.latitude, pose.longitude)
        ground, water = (pose.latitude, pose.longitude), self.water_altitude
        self._origin, below = ecef_of_places([(*ground, water + pose.height), (*ground, water)])
        a, b = SEMI_MAJOR_M + self.water_altitude, SEMI_MINOR_M + self.water_altitude
        scale = np.array([1.0 / a, 1.0 / a, 1.0 / b])
        self._place = self._origin * scale
        below = below * scale
        # |camera|² - |below|² of the scaled points, without subtracting nearly equal squares
        self._above = float((self._place - below) @ (self._place + below))
        self._turn = self._axes * scale  # (3, 3): direction ENU @ this is the scaled direction
        self.enu_from_optical: Array = pose.enu_from_camera @ FLU_FROM_OPTICAL
        self.dip = math.acos(MEAN_RADIUS_M / (MEAN_RADIUS_M + max(pose.height, 0.0)))

    def distances(self, directions: Array) -> Array:
        """Return distances of the water along unit directions (n, 3) ENU, m; NaN if none."""
        return self._distances(directions @ self._turn)

    def intersect(self, directions: Array) -> tuple[Array, Array]:
        """Return the distances (n,) and the water's normals there (n, 3) ENU, outward.

        Args:
            directions: (n, 3) unit, ENU.

        Returns:
            A normal's length makes its scalar product with the direction 1.
        """
        scaled = directions @ self._turn
        distances = self._distances(scaled)
        normals = (self._place + scaled * distances[:, None]) @ self._turn.T
        normals /= row_products(normals, directions)[:, None]
        return distances, normals

    def _distances(self, d: Array) -> Array:
        a = row_products(d, d)
        b = d @ self._place
        c = self._above
        discriminant = b * b - a * c
        hit = (discriminant > 0.0) & (b < 0.0)
        if c > 0.0 and all(hit.tolist()):
            return np.asarray(c / (np.sqrt(discriminant) - b), np.float64)
        hit &= c > 0.0
        # The smaller root, written so that nothing nearly equal is subtracted.
        return np.where(
            hit, c / np.where(hit, np.sqrt(np.where(hit, discriminant, 1.0)) - b, 1.0), np.nan
        )

    def normals(self, offsets: Array) -> Array:
        """Return outward unit normals (n, 3) ENU of the water at points (n, 3) ENU."""
        gradient = (self._place + offsets @ self._turn) @ self._turn.T
        square = row_products(gradient, gradient)
        normals: Array = gradient / np.sqrt(square)[:, None]
        return normals

    def geodetic(self, offsets: Array) -> tuple[Array, Array, Array]:
        """Return latitude, longitude (rad), altitude (m) of points (n, 3) ENU."""
        return geodetic_from_ecef(self._origin + offsets @ self._axes)
