# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The local frame `map`: East and North on the plane tangent at its origin."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geometry.geodesy import (
    SEMI_MAJOR_M,
    ecef_from_geodetic,
    ecef_of_place,
    enu_axes,
    geodetic_from_ecef,
)
from aerial_gnss_ros.core.values.estimates import MapDatum

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalMap:
    """East and North of points on the water, and back.

    The water is taken at the origin's altitude: 50 m of altitude change a distance of 1 km by
    8 mm, and only when the altitude is unknown to begin with.
    """

    datum: MapDatum

    @cached_property
    def axes(self) -> Array:
        """(3, 3) enu_from_ecef at the origin."""
        return enu_axes(self.datum.latitude, self.datum.longitude)

    @cached_property
    def origin(self) -> Array:
        """(3,) Earth-centred place of the origin, at altitude 0, m."""
        return ecef_of_place(self.datum.latitude, self.datum.longitude, 0.0)

    def positions(self, latitude: ArrayLike, longitude: ArrayLike) -> Array:
        """Return (n, 2) East, North in m of places in rad."""
        offsets = ecef_from_geodetic(latitude, longitude, 0.0) - self.origin
        positions: Array = offsets @ self.axes[:2].T
        return positions

    def places(self, positions: Array) -> tuple[Array, Array]:
        """Return latitude and longitude in rad, (n,) each, of (n, 2) East, North in m."""
        points = on_water_surface(positions)
        latitude, longitude, _ = geodetic_from_ecef(self.origin + points @ self.axes)
        return latitude, longitude


def on_water_surface(positions: Array) -> Array:
    """Return (n, 3) East, North, Up of places (n, 2) on the water.

    The ellipsoid lies D²/2R below the tangent plane.
    """
    points = np.empty((len(positions), 3))
    points[:, :2] = positions
    east, north = points[:, 0], points[:, 1]
    points[:, 2] = (east * east + north * north) * (-0.5 / SEMI_MAJOR_M)
    return points
