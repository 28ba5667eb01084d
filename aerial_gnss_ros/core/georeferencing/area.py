# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests which points on the water are outside the area of operation, beyond their uncertainty."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.area_of_operation import Polygon
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.numerics.small_arrays import row_products
from aerial_gnss_ros.core.values.estimates import MapDatum

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

OUTSIDE_SIGMAS = 3.0
"""Distance from the nearest edge, in sigmas, from which a point counts as outside."""


class AreaOfOperation:
    """Polygons with holes on the water.

    Args:
        polygons: rings of longitude and latitude in degrees, the outer one first. Edges are
            straight on the plane tangent at the first corner.
    """

    def __init__(self, polygons: tuple[Polygon, ...]) -> None:
        longitude, latitude = np.deg2rad(polygons[0][0][0])
        self._local = LocalMap(MapDatum(float(latitude), float(longitude), np.nan))
        self._edges = [_edges(self._local, polygon) for polygon in polygons]

    def outside(self, points: WaterPoints) -> Mask:
        """Return which points (n,) are outside, beyond their uncertainty; refused ones are not.

        Args:
            points: used with their full covariance, including the shared part.
        """
        valid = points.valid
        found = np.zeros(len(points), dtype=np.bool_)
        if not valid.any():
            return found
        places = self._local.positions(points.latitude[valid], points.longitude[valid])
        away = self._away(places)
        distance = np.sqrt(row_products(away, away))
        along = away / np.maximum(distance, 1e-9)[:, None]
        variance = np.einsum("ni,nij,nj->n", along, points.covariance[valid], along)
        found[valid] = distance > OUTSIDE_SIGMAS * np.sqrt(variance)
        return found

    def distance(self, latitude: float, longitude: float) -> float:
        """Return the distance of a position (rad) outside, m; 0 inside."""
        away = self._away(self._local.positions([latitude], [longitude]))
        return float(np.hypot(*away[0]))

    def _away(self, places: Array) -> Array:
        """Return the vectors (n, 2) from the nearest edge to positions outside, m; 0 inside."""
        inside = np.zeros(len(places), dtype=np.bool_)
        for first, second in self._edges:
            inside |= _even_odd(places, first, second)
        first = np.concatenate([edge[0] for edge in self._edges])
        step = np.concatenate([edge[1] for edge in self._edges]) - first
        to = places[:, None] - first
        along = (to * step).sum(axis=2) / np.maximum((step * step).sum(axis=1), 1e-12)
        away = to - np.clip(along, 0.0, 1.0)[..., None] * step
        nearest = np.argmin((away * away).sum(axis=2), axis=1)
        outward: Array = away[np.arange(len(places)), nearest]
        outward[inside] = 0.0
        return outward


def _edges(local: LocalMap, polygon: Polygon) -> tuple[Array, Array]:
    """Return start and end of the edges of all rings, (m, 2) East, North in m each."""
    rings = []
    for ring in polygon:
        longitude, latitude = np.deg2rad(ring).T
        rings.append(local.positions(latitude, longitude))
    ends = [np.roll(ring, -1, axis=0) for ring in rings]
    return np.concatenate(rings), np.concatenate(ends)


def _even_odd(places: Array, first: Array, second: Array) -> Mask:
    """Return the positions (n,) from which a line to the east crosses an odd number of edges."""
    east, north = places[:, :1], places[:, 1:]
    spans = (first[:, 1] > north) != (second[:, 1] > north)
    rise = second[:, 1] - first[:, 1]
    share = (north - first[:, 1]) / np.where(rise == 0.0, 1.0, rise)
    crossed = spans & (east < first[:, 0] + share * (second[:, 0] - first[:, 0]))
    odd: Mask = np.count_nonzero(crossed, axis=1) % 2 == 1
    return odd
