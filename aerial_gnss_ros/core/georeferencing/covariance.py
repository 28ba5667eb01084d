# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""First-order uncertainty of a point on the water from stated sensor standard deviations.

With a ray of direction d from a camera at P to distance t on a surface of normal n, a small change
moves the point by (I - d n' / (n.d)) (dP + t dd): it slides along the ray until it is on the
surface again. Derivatives are exact for the curved surface; only their use is first order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import skew
from aerial_gnss_ros.core.geometry.gimbal import Reference, error_axes
from aerial_gnss_ros.core.geometry.water_surface import SurfaceView
from aerial_gnss_ros.core.numerics.small_arrays import all_finite
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]

_LEVEL = np.eye(2, 3)
_RAISE = np.array([[0.0, -1.0], [1.0, 0.0]])
"""level @ _RAISE @ w: the third part of w × d."""


@dataclass(frozen=True)
class RayPoints:
    """Points where pixels' rays meet the water, with derivatives by all measured quantities.

    Attributes:
        offsets: (n, 3) East, North, Up from the camera, m; NaN where a ray misses the water.
        directions: (n, 3) unit rays, ENU.
        distances: (n,) from the camera, m.
        in_image: (n,) whether the camera model covers the pixel.
        directions_by_pixel: (n, 3, 2) derivative of the unit rays, 1/px.
        by_pixel: (n, 2, 2) East, North by u, v, m/px.
        by_rotation: (n, 2, 3) East, North by a small rotation vector w in ENU (the true
            orientation is exp(skew(w)) @ enu_from_camera), m/rad.
        by_height: (n, 2) East, North by the camera's height over the water, m/m.
        by_position: (2, 2) East, North by the camera's East, North: the identity. (To one part in a
            million: the horizontal rotates with the position.)
    """

    offsets: Array
    directions: Array
    distances: Array
    in_image: NDArray[np.bool_]
    directions_by_pixel: Array
    by_pixel: Array
    by_rotation: Array
    by_height: Array
    by_position: Array


def ray_points(view: SurfaceView, camera: CameraModel, pixels: Array) -> RayPoints:
    """Return where the rays of pixels (n, 2) meet the water, with all derivatives.

    Args:
        view: the camera over the water.
        camera: its intrinsics.
        pixels: (n, 2) u, v of the raw image (of the rectified one where the model says so).
    """
    rays, rays_by_pixel, in_image = camera.rays_with_jacobian(pixels)
    directions = rays @ view.enu_from_optical.T
    by_pixel = view.enu_from_optical @ rays_by_pixel
    distances, normals = view.intersect(directions)
    # (n, 2, 3): the horizontal rows of I - d n' / (n.d)
    slide = _LEVEL - directions[:, :2, None] * normals[:, None, :]
    reach = slide * distances[:, None, None]
    return RayPoints(
        offsets=directions * distances[:, None],
        directions=directions,
        distances=distances,
        in_image=in_image,
        directions_by_pixel=by_pixel,
        by_pixel=reach @ by_pixel,
        by_rotation=reach @ skew(-directions),
        by_height=slide[:, :, 2],
        by_position=_LEVEL[:, :2],
    )


@dataclass(frozen=True)
class Uncertainty:
    """Sigmas of measured quantities in SI, sorted by the errors' behaviour over time.

    Attributes:
        rotation_slow: (3, 3) in ENU, rad: the axes of roll, pitch and heading, one sigma long.
        rotation_white: (3,) of the small rotation about East, North, Up, rad.
        height_slow: m.
        height_white: m.
        position_slow: (2, 2) covariance of East, North, m².
        position_white: (2, 2) likewise.
        pixel: of u and of v, px.
    """

    rotation_slow: Array
    rotation_white: Array
    height_slow: float
    height_white: float
    position_slow: Array
    position_white: Array
    pixel: float


def uncertainty(pose: CameraPose, noise: Noise, reference: Reference | str) -> Uncertainty:
    """Return the sigmas for one camera pose.

    Args:
        pose: its fix covariance, if any, replaces the noise's GNSS offset.
        noise: standard deviations.
        reference: of the gimbal; decides whether the body's attitude noise enters.
    """
    stated, own = _stated(noise, reference), pose.fix_covariance
    if own is None or not all_finite(own):
        own = stated.position_slow
    between = pose.interpolation
    return Uncertainty(
        error_axes(pose.enu_from_camera) * stated.rotation_slow,
        np.sqrt(np.square(stated.rotation_white) + between[3:]),
        stated.height_slow,
        math.sqrt(stated.height_white**2 + float(between[2])),
        own,
        stated.position_white + _LEVEL[:, :2] * between[:2],
        stated.pixel,
    )


@lru_cache(maxsize=8)
def _stated(noise: Noise, reference: Reference | str) -> Uncertainty:
    """Return what does not depend on the pose; the slow rotation as (3,): roll, pitch, heading."""
    names = ("gimbal_roll_deg", "gimbal_pitch_deg", "heading_deg")
    return Uncertainty(
        rotation_slow=np.array([math.radians(noise.value(name)) for name in names]),
        rotation_white=np.sqrt(white_rotation(noise, Reference(reference))),
        height_slow=noise.value("height_m"),
        height_white=noise.value("height_white_m"),
        position_slow=np.eye(2) * noise.value("gnss_offset_m") ** 2,
        position_white=np.eye(2) * noise.value("gnss_white_m") ** 2,
        pixel=noise.value("box_center_px"),
    )


def white_rotation(noise: Noise, reference: Reference) -> list[float]:
    """Return the variances of the white rotation about East, North and Up, rad²."""
    gimbal = math.radians(noise.value("gimbal_white_deg")) ** 2
    attitude = math.radians(noise.value("attitude_white_deg")) ** 2
    if reference is Reference.EARTH:
        return [gimbal] * 3
    if reference is Reference.HEADING:  # only the body's yaw is used
        return [gimbal, gimbal, gimbal + attitude]
    return [attitude + (gimbal if reference.needs_gimbal else 0.0)] * 3


def covariances(points: RayPoints, known: Uncertainty) -> tuple[Array, Array]:
    """Return the white and the slow covariance of the points, (n, 2, 2) each, East, North, m².

    White parts are independent from image to image; slow ones are shared by all robots and stay
    for minutes.
    """
    turn, lift, n = points.by_rotation, points.by_height, len(points.distances)
    white, slow = np.empty((n, 2, 6)), np.empty((n, 2, 4))
    white[:, :, :3] = turn * known.rotation_white
    white[:, :, 3] = lift * known.height_white
    white[:, :, 4:] = points.by_pixel * known.pixel
    slow[:, :, :3] = turn @ known.rotation_slow
    slow[:, :, 3] = lift * known.height_slow
    return (
        white @ white.swapaxes(1, 2) + known.position_white,
        slow @ slow.swapaxes(1, 2) + known.position_slow,
    )


def elevation_sigma(points: RayPoints, known: Uncertainty) -> Array:
    """Return one sigma (n,) of the rays' elevation above the horizon, rad."""
    level = points.directions[:, :2]
    # A small rotation w raises a ray of direction d by (w × d)_z, and that by its horizontal
    # length.
    tilts = np.empty((len(level), 7))
    tilts[:, :3] = level @ (_RAISE @ known.rotation_slow[:2])
    tilts[:, 3:5] = level @ (_RAISE * known.rotation_white[:2])
    tilts[:, 5:] = points.directions_by_pixel[:, 2] * known.pixel
    across = np.maximum(np.add.reduce(np.square(level), axis=1), 1e-18)
    sigma: Array = np.sqrt(np.add.reduce(np.square(tilts), axis=1) / across)
    return sigma
