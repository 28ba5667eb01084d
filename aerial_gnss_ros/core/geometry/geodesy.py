# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""WGS84: geodetic, Earth-centred (ECEF) and local East-North-Up coordinates, `map`; geodesics.

Angles are radians, lengths metres. PROJ (through pyproj) does the work that is easy to get wrong:
Earth-centred to geodetic (of a few points its formula is here, a call of it takes longer than ten
of them), and geodesics (Karney 2013). The haversine is here because the paper measures with it; it
is a sphere's and wrong by up to 0.6 %.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pyproj import Geod, Transformer

from aerial_gnss_ros.core.numerics.columns import columns
from aerial_gnss_ros.core.values.estimates import MapDatum

Array = NDArray[np.float64]

SEMI_MAJOR_M = 6378137.0
FLATTENING = 1.0 / 298.257223563
SEMI_MINOR_M = SEMI_MAJOR_M * (1.0 - FLATTENING)
MEAN_RADIUS_M = 6371008.8
"""Mean radius (2a + b) / 3 of the sphere that `haversine` uses."""

_FALL = -0.5 / SEMI_MAJOR_M
"""Height of the ellipsoid over its tangent plane, by the squared distance, 1/m."""
_E2 = FLATTENING * (2.0 - FLATTENING)
_FEW = 12
"""Up to so many places are computed one by one, which is faster than arrays of them."""

_GEOD = Geod(ellps="WGS84")


@lru_cache(maxsize=1)
def _cart() -> Transformer:
    return Transformer.from_pipeline("+proj=cart +ellps=WGS84")


def ecef_from_geodetic(latitude: ArrayLike, longitude: ArrayLike, altitude: ArrayLike) -> Array:
    """Return Earth-centred x, y, z (..., 3) in m of latitude, longitude (rad), altitude (m)."""
    lat, lon = np.asarray(latitude, np.float64), np.asarray(longitude, np.float64)
    alt = np.asarray(altitude, np.float64)
    if lat.ndim == lon.ndim == 1 and not alt.ndim and len(lat) == len(lon) <= _FEW:
        return ecef_of_places(zip(lat.tolist(), lon.tolist(), repeat(float(alt))))
    sin_lat, cos_lat = np.sin(lat), np.cos(lat)
    prime = SEMI_MAJOR_M / np.sqrt(1.0 - _E2 * sin_lat * sin_lat)
    across = (prime + alt) * cos_lat
    xyz = np.empty((*np.broadcast_shapes(across.shape, lon.shape), 3))
    xyz[..., 0], xyz[..., 1] = across * np.cos(lon), across * np.sin(lon)
    xyz[..., 2] = (prime * (1.0 - _E2) + alt) * sin_lat
    return xyz


def ecef_of_places(places: Iterable[tuple[float, float, float]]) -> Array:
    """Return the same (n, 3) of a few places; in plain numbers, ten times as fast."""
    found: list[tuple[float, float, float]] = []
    for latitude, longitude, altitude in places:
        sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
        prime = SEMI_MAJOR_M / math.sqrt(1.0 - _E2 * sin_lat * sin_lat)
        across = (prime + altitude) * cos_lat
        up = (prime * (1.0 - _E2) + altitude) * sin_lat
        found.append((across * math.cos(longitude), across * math.sin(longitude), up))
    return np.array(found).reshape(-1, 3)


def ecef_of_place(latitude: float, longitude: float, altitude: float) -> Array:
    """Return the same (3,) of one place."""
    place: Array = ecef_of_places([(latitude, longitude, altitude)])[0]
    return place


def geodetic_from_ecef(xyz: ArrayLike) -> tuple[Array, Array, Array]:
    """Return latitude, longitude (rad) and altitude (m) of Earth-centred points (..., 3) in m."""
    points = np.asarray(xyz, dtype=np.float64)
    flat, shape = points.reshape(-1, 3), points.shape[:-1]
    if len(flat) <= _FEW:
        few = _geodetic(flat.tolist())
        if few is not None:
            table = np.array(few).reshape(*shape, 3)
            return table[..., 0], table[..., 1], table[..., 2]
    # pyproj 3.6 warns of arrays with one element, so a single point goes in as plain numbers.
    x, y, z = flat[0].tolist() if len(flat) == 1 else columns(flat)
    lon, lat, alt = _cart().transform(x, y, z, radians=True, direction="INVERSE")
    latitude, longitude, altitude = (np.asarray(one).reshape(shape) for one in (lat, lon, alt))
    return latitude, longitude, altitude


def _geodetic(points: list[list[float]]) -> list[tuple[float, float, float]] | None:
    """Return the same of a few points in plain numbers, by Bowring (1976) as PROJ does.

    None if the formula does not hold: at a pole, deep inside the Earth, or for NaN.
    """
    found: list[tuple[float, float, float]] = []
    for x, y, z in points:
        level = math.hypot(x, y)
        upward, outward = z * SEMI_MAJOR_M, level * SEMI_MINOR_M
        scale = math.hypot(upward, outward)
        if not 0.5 * SEMI_MINOR_M**2 < scale < math.inf:
            return None
        sine, cosine = upward / scale, outward / scale
        rise = z + _E2 / (1.0 - _E2) * SEMI_MINOR_M * sine * sine * sine
        run = level - _E2 * SEMI_MAJOR_M * cosine * cosine * cosine
        if run < 1e-6 * abs(rise):
            return None
        steep = math.hypot(rise, run)
        sin_lat, cos_lat = rise / steep, run / steep
        prime = SEMI_MAJOR_M / math.sqrt(1.0 - _E2 * sin_lat * sin_lat)
        found.append((math.atan(rise / run), math.atan2(y, x), level / cos_lat - prime))
    return found


@lru_cache(maxsize=8)  # several callers need the axes at one image's camera
def enu_axes(latitude: float, longitude: float) -> Array:
    """Return enu_from_ecef, (3, 3): its rows are East, North, Up at a position (rad); read-only."""
    sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
    sin_lon, cos_lon = math.sin(longitude), math.cos(longitude)
    axes = np.array(
        [
            [-sin_lon, cos_lon, 0.0],
            [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
        ]
    )
    axes.flags.writeable = False
    return axes


def enu_from_geodetic(
    latitude: ArrayLike,
    longitude: ArrayLike,
    altitude: ArrayLike,
    latitude0: float,
    longitude0: float,
    altitude0: float,
) -> Array:
    """Return East, North, Up in m, (..., 3), of points relative to an origin (rad, m).

    The plane is tangent at the origin: a point D away on the ground lies D²/2R below it.
    """
    origin = ecef_of_place(latitude0, longitude0, altitude0)
    offset = ecef_from_geodetic(latitude, longitude, altitude) - origin
    enu: Array = offset @ enu_axes(latitude0, longitude0).T
    return enu


def geodetic_from_enu(
    east: ArrayLike,
    north: ArrayLike,
    up: ArrayLike,
    latitude0: float,
    longitude0: float,
    altitude0: float,
) -> tuple[Array, Array, Array]:
    """Return latitude, longitude (rad) and altitude (m) of East, North, Up (m) from an origin."""
    parts = [np.asarray(part, np.float64) for part in (east, north, up)]
    enu = np.empty((*np.broadcast_shapes(*(part.shape for part in parts)), 3))
    for axis, part in enumerate(parts):
        enu[..., axis] = part
    origin = ecef_of_place(latitude0, longitude0, altitude0)
    return geodetic_from_ecef(origin + enu @ enu_axes(latitude0, longitude0))


def geodesic_inverse(
    latitude1: ArrayLike, longitude1: ArrayLike, latitude2: ArrayLike, longitude2: ArrayLike
) -> tuple[Any, Any, Any]:
    """Return distance (m), azimuth at point 1 and azimuth at point 2 (rad) of the geodesic.

    Azimuths are compass directions of travel: 0 north, clockwise, within +-pi. All of one shape.
    """
    azimuth1, back, distance = _GEOD.inv(longitude1, latitude1, longitude2, latitude2, radians=True)
    onward = (np.asarray(back) + 2.0 * math.pi) % (2.0 * math.pi) - math.pi
    return distance, azimuth1, onward if np.ndim(back) else float(onward)


def metres_per_radian(latitude: float) -> tuple[float, float]:
    """Return the lengths of a radian of longitude and of latitude on the ellipsoid, m."""
    squared = 1.0 - _E2 * math.sin(latitude) ** 2
    across = SEMI_MAJOR_M / math.sqrt(squared)
    return across * math.cos(latitude), across * (1.0 - _E2) / squared


def haversine(
    latitude1: ArrayLike, longitude1: ArrayLike, latitude2: ArrayLike, longitude2: ArrayLike
) -> Any:
    """Return distances in m on the sphere of mean radius, as in the paper (rad in)."""
    lat1, lat2 = np.asarray(latitude1, np.float64), np.asarray(latitude2, np.float64)
    half = 0.5 * (np.asarray(longitude2, np.float64) - np.asarray(longitude1, np.float64))
    chord = np.sin(0.5 * (lat2 - lat1)) ** 2 + np.cos(lat1) * np.cos(lat2) * np.sin(half) ** 2
    return 2.0 * MEAN_RADIUS_M * np.arcsin(np.sqrt(np.clip(chord, 0.0, 1.0)))


@dataclass(frozen=True)
class LocalMap:
    """The frame `map`: East and North on the plane tangent at its origin, of points on the water.

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
    squares = np.square(positions)
    points[:, 2] = (squares[:, 0] + squares[:, 1]) * _FALL
    return points
