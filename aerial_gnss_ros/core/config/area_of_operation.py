# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parses an area of operation: GeoJSON (RFC 7946) polygons with holes."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import cut, shown

Array = NDArray[np.float64]
Polygon = tuple[Array, ...]
"""Rings of (n, 2) longitude, latitude in degrees, without the repeated last corner: the outer one,
then holes."""

MAX_CORNERS = 2000
MAX_DEPTH = 20
MAX_EXTENT_DEG = 2.0


def polygons_from_geojson(text: str) -> tuple[Polygon, ...]:
    """Return the polygons of a geometry, feature or collection.

    Args:
        text: a JSON document, longitude before latitude, in degrees (WGS84).

    Raises:
        ConfigError: not GeoJSON, no polygon, or an invalid one: too few corners, crossing edges,
            not in degrees, latitude and longitude swapped, or larger than any area of operation.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"The area of operation is not JSON ({cut(str(error))}).") from error
    polygons = tuple(_polygon(rings) for rings in _polygon_coordinates(document, MAX_DEPTH))
    if not polygons:
        raise ConfigError(
            "The area of operation holds no polygon; draw one and export it as GeoJSON."
        )
    corners = sum(len(ring) for polygon in polygons for ring in polygon)
    if corners > MAX_CORNERS:
        raise ConfigError(
            f"The area of operation has {corners} corners, more than {MAX_CORNERS}; simplify it."
        )
    for polygon in polygons:
        _check_crossings(polygon)
    _check_extent(np.concatenate([ring for polygon in polygons for ring in polygon]))
    return polygons


def _polygon_coordinates(node: Any, depth: int) -> Iterator[Any]:
    """Yield the coordinates of all polygons in a document."""
    kind = node.get("type") if isinstance(node, dict) else None
    if kind is None or depth == 0:
        raise ConfigError(f"The area of operation is not GeoJSON: {shown(node)} has no type.")
    if kind == "Polygon":
        yield node.get("coordinates")
    elif kind == "MultiPolygon":
        yield from _list(node.get("coordinates"))
    elif kind == "Feature":
        if node.get("geometry") is not None:
            yield from _polygon_coordinates(node["geometry"], depth - 1)
    elif kind in ("FeatureCollection", "GeometryCollection"):
        for part in _list(node.get("features" if kind[0] == "F" else "geometries")):
            yield from _polygon_coordinates(part, depth - 1)
    else:
        raise ConfigError(f"The area of operation holds a {cut(str(kind))}; only polygons count.")


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise ConfigError(
            f"The area of operation is not GeoJSON: {shown(value)} stands where a list with "
            "content belongs."
        )
    return value


def _polygon(rings: Any) -> Polygon:
    return tuple(_ring(ring) for ring in _list(rings))


def _ring(corners: Any) -> Array:
    places = [_corner(corner) for corner in _list(corners)]
    if len(places) > 1 and places[0] == places[-1]:
        places.pop()
    if len(set(places)) < 3:
        raise ConfigError(
            f"The area of operation has a polygon with {len(set(places))} different corners; it "
            "needs at least 3."
        )
    ring = np.array(places)
    # Across the antimeridian, longitudes continue beyond 180 degrees.
    ring[:, 0] = np.rad2deg(np.unwrap(np.deg2rad(ring[:, 0])))
    return ring


def _corner(corner: Any) -> tuple[float, float]:
    place = [_number(one) for one in _list(corner)[:2]]
    if len(place) != 2 or not all(map(math.isfinite, place)):
        raise ConfigError(
            f"The area of operation has the corner {shown(corner)}; give [longitude, latitude] in "
            "degrees."
        )
    longitude, latitude = place
    if abs(latitude) > 90.0 and abs(latitude) <= 180.0 and abs(longitude) <= 90.0:
        raise ConfigError(
            f"The area of operation has the corner {shown(corner)}, whose latitude and longitude "
            "are swapped: GeoJSON has longitude first."
        )
    if abs(latitude) > 90.0 or abs(longitude) > 180.0:
        raise ConfigError(
            f"The area of operation has the corner {shown(corner)}, which is not in degrees; "
            "export it in WGS84 (EPSG:4326)."
        )
    return longitude, latitude


def _number(value: Any) -> float:
    """Return a number; NaN for other values or numbers too large."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return math.nan
    return float(value) if abs(value) < 1e9 else math.nan  # float() of a huge one raises


def _check_crossings(polygon: Polygon) -> None:
    """Refuse edges that cross one another, of one ring or of two."""
    first = np.concatenate(polygon)
    second = np.concatenate([np.roll(ring, -1, axis=0) for ring in polygon])

    def side(of: Array) -> Array:
        """Return on which side of edge i point j lies, (n, n)."""
        edge, to = (second - first)[:, None], of[None] - first[:, None]
        turn: Array = np.sign(edge[..., 0] * to[..., 1] - edge[..., 1] * to[..., 0])
        return turn

    apart = side(first) * side(second) < 0.0
    crossing = np.argwhere(apart & apart.T)
    if len(crossing):
        longitude, latitude = first[crossing[0, 0]]
        raise ConfigError(
            "The area of operation has a polygon that crosses itself, beside longitude "
            f"{longitude:.7g}, latitude {latitude:.7g}; draw it without crossing edges."
        )


def _check_extent(corners: Array) -> None:
    longitude, latitude = np.ptp(corners, axis=0)
    if max(longitude * math.cos(math.radians(corners[0, 1])), latitude) > MAX_EXTENT_DEG:
        raise ConfigError(
            f"The area of operation extends over {longitude:.3g} degrees of longitude and "
            f"{latitude:.3g} of latitude, more than any drone flies; check its corners."
        )
