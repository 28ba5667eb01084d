# SPDX-License-Identifier: Apache-2.0
"""The local frame `map`: East and North on the plane tangent at its origin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geodesy import SEMI_MAJOR_M, enu_from_geodetic, geodetic_from_enu
from aerial_gnss_ros.core.values import MapDatum

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalMap:
    """East and North of points on the water, and back.

    The water is taken at the origin's altitude: 50 m of altitude change a distance of 1 km by
    8 mm, and only when the altitude is unknown to begin with.
    """

    datum: MapDatum

    def positions(self, latitude: ArrayLike, longitude: ArrayLike) -> Array:
        """Return (n, 2) East, North in m of places in rad."""
        origin = self.datum.latitude, self.datum.longitude, 0.0
        enu = enu_from_geodetic(latitude, longitude, 0.0, *origin)
        return np.asarray(enu[..., :2], np.float64)

    def places(self, positions: Array) -> tuple[Array, Array]:
        """Return latitude and longitude in rad, (n,) each, of (n, 2) East, North in m."""
        east, north = positions[..., 0], positions[..., 1]
        # the ellipsoid lies D²/2R below the tangent plane
        up = -(east**2 + north**2) / (2.0 * SEMI_MAJOR_M)
        origin = self.datum.latitude, self.datum.longitude, 0.0
        latitude, longitude, _ = geodetic_from_enu(east, north, up, *origin)
        return latitude, longitude
