# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From pixels to positions on the water, each with its covariance or a typed refusal."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import skew
from aerial_gnss_ros.core.geometry.refraction import depth_slopes, submerged_offsets
from aerial_gnss_ros.core.geometry.water_surface import SurfaceView
from aerial_gnss_ros.core.georeferencing.covariance import (
    RayPoints,
    covariances,
    elevation_sigma,
    ray_points,
    uncertainty,
)
from aerial_gnss_ros.core.georeferencing.size_fit import SizeFit
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Reason

Array = NDArray[np.float64]

HORIZON_SIGMAS = 3.0
"""Least angle of a ray below the horizon, in sigmas of its elevation: closer, the error is too
skewed for a covariance (reference: geolocation, 2.2)."""


@dataclass(frozen=True)
class WaterPoints:
    """Positions of n pixels on the water. Values of refused ones are NaN.

    Attributes:
        latitude: (n,) rad, WGS84.
        longitude: (n,) rad.
        altitude: of the water above the ellipsoid, m; NaN if the datum is unknown.
        east_north: (n, 2) from the camera's ground point, in the plane level at the camera, m.
        range_m: (n,) from the camera, m.
        covariance_white: (n, 2, 2) East, North, m²: independent from image to image.
        covariance_slow: (n, 2, 2) East, North, m²: shared by all robots, stays for minutes.
        pixels: (n, 2) of the surface points above the robots: the measured ones, corrected for
            refraction of submerged robots.
        reasons: of refusal, or None.
        sizes: of their boxes, where a length is stated for a class; else None.
    """

    latitude: Array
    longitude: Array
    altitude: float
    east_north: Array
    range_m: Array
    covariance_white: Array
    covariance_slow: Array
    pixels: Array
    reasons: tuple[Reason | None, ...]
    sizes: SizeFit | None = None

    def __len__(self) -> int:
        return len(self.reasons)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(n,) whether there is a position."""
        return np.array([reason is None for reason in self.reasons], dtype=np.bool_)

    @property
    def covariance(self) -> Array:
        """(n, 2, 2) East, North, m²: all of it, for a position used by itself."""
        total: Array = self.covariance_white + self.covariance_slow
        return total


def locate(
    pose: CameraPose,
    camera: CameraModel,
    pixels: ArrayLike,
    noise: Noise,
    config: EstimatorConfig | None = None,
    depths: Array | None = None,
) -> WaterPoints:
    """Return positions of robots on or below the water by the exact ray, for one image.

    Args:
        pose: the camera at the time of the scene.
        camera: its intrinsics.
        pixels: (n, 2) u, v.
        noise: sensor standard deviations.
        config: limits of range and sigma, and the gimbal's reference; None for the defaults.
        depths: (n,) of the robots below the surface, m; None: 0.
    """
    config = config or EstimatorConfig()
    given = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    bad = bad_pose(pose)
    if bad is not None:
        return all_refused(len(given), bad)
    view = SurfaceView(pose)
    points = ray_points(view, camera, given)
    if depths is not None and depths.any():
        points = submerged(points, depths)
    known = uncertainty(pose, noise, config.gimbal.reference)
    white, slow = covariances(points, known)
    if config.depth.sigma_m:
        slope = config.depth.sigma_m * depth_slopes(points.directions)
        slow = slow + slope[:, :, None] * slope[:, None, :]
    depression = np.arcsin(np.minimum(np.maximum(-points.directions[:, 2], -1.0), 1.0))
    margin = depression - view.dip - HORIZON_SIGMAS * elevation_sigma(points, known)
    total, limits = white + slow, config.surface
    good = (points.distances <= limits.max_range) & (margin > 0.0) & points.in_image
    good &= total[:, 0, 0] + total[:, 1, 1] <= limits.max_sigma_m**2
    reasons: tuple[Reason | None, ...] = (None,) * len(good)
    if not all(good.tolist()):
        reasons = _reasons(given, points, margin, total, config)
    latitude, longitude, _ = view.geodetic(points.offsets)
    found = WaterPoints(
        latitude,
        longitude,
        pose.altitude - pose.height,
        points.offsets[:, :2],
        points.distances,
        white,
        slow,
        given if depths is None else _seen_at_surface(view, camera, given, points, depths),
        reasons,
    )
    return mask_refused(found) if any(reasons) else found


def submerged(points: RayPoints, depths: Array) -> RayPoints:
    """Return points below the surface, shifted by refraction, with their derivatives.

    Args:
        points: where the rays meet the surface.
        depths: (n,) m.
    """
    beyond, by_level = submerged_offsets(points.directions, depths)
    offsets = points.offsets.copy()
    offsets[:, :2] += beyond
    turned = -skew(points.directions)[:, :2]
    return replace(
        points,
        offsets=offsets,
        by_pixel=points.by_pixel + by_level @ points.directions_by_pixel[:, :2],
        by_rotation=points.by_rotation + by_level @ turned,
    )


def _seen_at_surface(
    view: SurfaceView, camera: CameraModel, given: Array, points: RayPoints, depths: Array
) -> Array:
    if not depths.any():
        return given
    pixels, _ = camera.project(np.nan_to_num(points.offsets) @ view.enu_from_optical)
    return np.where((depths > 0.0)[:, None], pixels, given)


def located_jacobian(pose: CameraPose, camera: CameraModel, pixels: ArrayLike) -> RayPoints:
    """Return where pixels' rays meet the water, with derivatives by all measured quantities.

    For filters that estimate the platform's errors. Nothing is refused: a ray that misses the water
    has NaN, `in_image` marks the pixels that the camera model covers.

    Args:
        pose: finite, above the water (see `bad_pose`).
        camera: its intrinsics.
        pixels: (n, 2) u, v.
    """
    return ray_points(SurfaceView(pose), camera, np.asarray(pixels, np.float64).reshape(-1, 2))


def bad_pose(pose: CameraPose) -> Reason | None:
    """Return why a pose is unusable, or None: not finite, or not above the water."""
    if not (math.isfinite(pose.latitude) and math.isfinite(pose.longitude)):
        return Reason.BAD_FIX
    if not (math.isfinite(pose.height) and pose.height > 0.0):
        return Reason.BAD_HEIGHT
    # One part that is not finite is enough.
    if not math.isfinite(sum(pose.enu_from_camera.ravel().tolist())):
        return Reason.BAD_GIMBAL
    return None


def largest_sigma(covariance: Array) -> Array:
    """Return the semi-major axis (n,) of one-sigma ellipses (n, 2, 2)."""
    a, b, d = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    root: Array = np.sqrt(0.5 * (a + d) + np.sqrt(0.25 * (a - d) ** 2 + b * b))
    return root


def _reasons(
    pixels: Array, points: RayPoints, margin: Array, covariance: Array, config: EstimatorConfig
) -> tuple[Reason | None, ...]:
    limits = config.surface
    sigma = largest_sigma(covariance)
    far = ~(points.distances <= limits.max_range) | ~(sigma <= limits.max_sigma_m)
    above = np.isnan(points.distances) | ~(margin > 0.0)
    unknown = ~np.isfinite(pixels).all(axis=1)
    found: list[Reason | None] = [None] * len(pixels)
    # The last applicable reason is reported, so earlier steps come later here.
    for reason, applies in (
        (Reason.OUT_OF_RANGE, far),
        (Reason.ABOVE_HORIZON, above),
        (Reason.OUTSIDE_CALIBRATED_IMAGE, ~points.in_image),
        (Reason.BAD_DETECTIONS, unknown),
    ):
        for i in np.flatnonzero(applies):
            found[i] = reason
    return tuple(found)


def mask_refused(points: WaterPoints) -> WaterPoints:
    """Return the points with NaN for refused ones, so that none is used by mistake."""
    if not any(points.reasons):
        return points
    wrong = ~points.valid

    def hidden(values: Array) -> Array:
        shape = (-1,) + (1,) * (values.ndim - 1)
        return np.where(wrong.reshape(shape), np.nan, values)

    return WaterPoints(
        hidden(points.latitude),
        hidden(points.longitude),
        points.altitude,
        hidden(points.east_north),
        hidden(points.range_m),
        hidden(points.covariance_white),
        hidden(points.covariance_slow),
        points.pixels,
        points.reasons,
        points.sizes,
    )


def all_refused(count: int, reason: Reason) -> WaterPoints:
    """Return `count` points that are all refused for one reason."""
    line, plane, square = (np.full((count, *shape), np.nan) for shape in ((), (2,), (2, 2)))
    return WaterPoints(line, line, math.nan, plane, line, square, square, plane, (reason,) * count)
