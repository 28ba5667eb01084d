# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Footprint of a camera: field of view, and water covered by a pixel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.water_surface import SurfaceView
from aerial_gnss_ros.core.georeferencing.localization import located_jacobian
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import CameraError

Array = NDArray[np.float64]

_PER_EDGE = 24  # points on each edge of the image: the horizon is met to 4 % of its width
_EVERY = 6  # where the whole edge shows water, so many are enough; the corners are among them


@dataclass(frozen=True)
class FieldOfView:
    """Angles in rad between opposite edges (middles) and corners; NaN where the lens model ends."""

    horizontal: float
    vertical: float
    diagonal: float


@dataclass(frozen=True)
class GroundSample:
    """Ground sample distance at a pixel.

    Attributes:
        place: centre, top or bottom.
        pixel: u, v.
        below_horizon: of the pixel's ray, rad.
        distance: horizontal distance from the drone to the point, m; NaN above the horizon.
        range_m: from the camera to the point, m.
        across: m of water from one pixel to its neighbour in the row.
        along: m of water from one pixel to its neighbour in the column.
    """

    place: str
    pixel: tuple[float, float]
    below_horizon: float
    distance: float
    range_m: float
    across: float
    along: float


def field_of_view(camera: CameraModel) -> FieldOfView:
    """Return the angles of view over the image's full width, height and diagonal."""
    right, bottom = camera.width - 0.5, camera.height - 0.5
    middle_u, middle_v = 0.5 * (camera.width - 1), 0.5 * (camera.height - 1)
    pairs = (
        ((-0.5, middle_v), (right, middle_v)),
        ((middle_u, -0.5), (middle_u, bottom)),
        ((-0.5, -0.5), (right, bottom)),
    )
    return FieldOfView(*(_angle(camera, np.array(pair)) for pair in pairs))


def ground_samples(
    camera: CameraModel, height: float, below_horizon: float
) -> tuple[GroundSample, ...]:
    """Return the water per pixel at the image's centre, top and bottom.

    Args:
        camera: its intrinsics.
        height: of the camera above the water, m.
        below_horizon: angle of the optical axis below the horizon, rad (pi/2: down).

    Raises:
        CameraError: a height that is not positive, or a tilt beyond straight down or up.
    """
    if not (math.isfinite(height) and height > 0.0):
        raise CameraError(f"The height must be above 0 m, not {height:g} m.")
    if not -0.5 * math.pi <= below_horizon <= 0.5 * math.pi:
        raise CameraError(
            f"The tilt must lie within -90 and 90 deg below the horizon (90: straight down), not "
            f"{math.degrees(below_horizon):g} deg."
        )
    orientation = matrix_from_rpy(0.0, below_horizon, 0.0)
    pose = CameraPose(0, 0.0, 0.0, height, math.nan, orientation)
    middle = 0.5 * (camera.width - 1)
    places = {"centre": 0.5 * (camera.height - 1), "top": 0.0, "bottom": camera.height - 1.0}
    pixels = np.array([(middle, v) for v in places.values()])
    points = located_jacobian(pose, camera, pixels)
    seen = points.in_image & np.isfinite(points.distances)
    across, along = (
        np.where(seen, np.linalg.norm(points.by_pixel[:, :, axis], axis=1), np.nan)
        for axis in (0, 1)
    )
    distances = np.where(seen, np.linalg.norm(points.offsets[:, :2], axis=1), np.nan)
    ranges = np.where(seen, points.distances, np.nan)
    depression = -np.arcsin(np.clip(points.directions[:, 2], -1.0, 1.0))
    return tuple(
        GroundSample(
            place,
            (middle, v),
            float(depression[i]),
            float(distances[i]),
            float(ranges[i]),
            float(across[i]),
            float(along[i]),
        )
        for i, (place, v) in enumerate(places.items())
    )


def outline(pose: CameraPose, camera: CameraModel, farthest: float) -> Array:
    """Return the water that an image shows: a polygon along the image's edge.

    Where the edge shows the sky, or water beyond `farthest`, it ends: the polygon closes straight
    between the last points on both sides.

    Args:
        pose: finite, above the water (see `bad_pose`).
        camera: its intrinsics.
        farthest: longest range of a point, m.

    Returns:
        (n, 2) latitude, longitude, rad, clockwise in the image from its top left corner; (0, 2) if
        less than a triangle is in view.
    """
    view = SurfaceView(pose)
    rays, valid = camera.rays(_border(camera))
    directions = rays @ view.enu_from_optical.T
    distances = view.distances(directions)
    seen = valid & (distances <= farthest)
    if seen.all():
        seen[:] = False
        seen[::_EVERY] = True
    if np.count_nonzero(seen) < 3:
        return np.empty((0, 2))
    latitude, longitude, _ = view.geodetic(directions[seen] * distances[seen, None])
    return np.stack([latitude, longitude], axis=-1)


def _border(camera: CameraModel) -> Array:
    """Return pixels (4 * `_PER_EDGE`, 2) along the image's edge, clockwise from its top left."""
    right, bottom = camera.width - 1.0, camera.height - 1.0
    corners = np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])
    share = np.arange(_PER_EDGE)[:, None] / _PER_EDGE
    edges = [
        start + share * (end - start)
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    ]
    return np.concatenate(edges)


def _angle(camera: CameraModel, pixels: Array) -> float:
    rays, valid = camera.rays(pixels)
    if not valid.all():
        return math.nan
    cross = float(np.linalg.norm(np.cross(rays[0], rays[1])))
    return math.atan2(cross, float(rays[0] @ rays[1]))
