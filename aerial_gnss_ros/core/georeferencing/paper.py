# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The paper's method, as its authors meant it: the baseline of every comparison.

"Scalable Aerial GNSS Localization for Marine Robots" (Wen et al., arXiv 2505.04095): the printed
equations with only these corrections: the sign of the vertical angle (pixels count down), latitude
and longitude the right way round, the quadrant of the bearing (atan2), the earth-referenced pitch
not doubled by the drone's, the camera's heading instead of the drone's, metres. Unchanged: no roll,
no lens distortion and no principal point, lateral distance too long by 1 / cos(vertical angle), a
sphere of 364,000 ft per degree.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import wrap_angle
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.georeferencing.localization import (
    WaterPoints,
    all_refused,
    bad_pose,
    mask_refused,
)
from aerial_gnss_ros.core.georeferencing.localization import locate as locate_exactly
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Reason

Array = NDArray[np.float64]

METRES_PER_DEGREE = 364_000.0 * 0.3048
"""The paper's 364,000 feet per degree of latitude."""


def view_angles(enu_from_camera: Array) -> tuple[float, float]:
    """Return the camera's angle off the vertical and its compass heading, rad; roll is ignored.

    The angle is negative if the camera looks backward past straight down.
    """
    forward = enu_from_camera[:, 0]
    east, north = error_axes(enu_from_camera)[:2, 0]
    level = math.hypot(forward[0], forward[1])
    if level > 1e-3:  # otherwise straight down: the top of the image has the heading
        sign = 1.0 if forward[0] * east + forward[1] * north >= 0.0 else -1.0
        east, north = sign * forward[0] / level, sign * forward[1] / level
    off_vertical = math.atan2(forward[0] * east + forward[1] * north, -forward[2])
    return off_vertical, math.atan2(east, north)


def ground_offsets(
    height: float, off_vertical: float, heading: float, camera: CameraModel, pixels: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return East, North (n, 2) in m by the paper's equations, and which are below the horizon.

    Args:
        height: camera over the water, m (the paper's A).
        off_vertical: of the camera, rad (alpha).
        heading: of the camera, rad (psi).
        camera: only its size and focal lengths are used, as the paper's field of view does.
        pixels: (n, 2) u, v.
    """
    theta_x = np.arctan((pixels[:, 0] - 0.5 * camera.width) / camera.K[0, 0])
    theta_y = np.arctan((pixels[:, 1] - 0.5 * camera.height) / camera.K[1, 1])
    angle = off_vertical - theta_y
    below = np.abs(angle) < 0.5 * math.pi
    ahead = height * np.tan(np.where(below, angle, 0.0))
    aside = np.sqrt(height**2 + ahead**2) * np.tan(theta_x)
    bearing = heading + np.arctan2(aside, ahead)
    distance = np.sqrt(np.sin(theta_x) ** 2 * height**2 + ahead**2) / np.cos(theta_x)
    return np.stack([distance * np.sin(bearing), distance * np.cos(bearing)], axis=1), below


def locate(
    pose: CameraPose,
    camera: CameraModel,
    pixels: ArrayLike,
    noise: Noise,
    config: EstimatorConfig | None = None,
    _depths: Array | None = None,
) -> WaterPoints:
    """Return positions on the water by the paper's equations; see `localization.locate`.

    The covariance, and refusals beyond the paper's own horizon, come from the exact method, so that
    all methods are compared on the same detections. The paper ignores refraction.
    """
    given = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    bad = bad_pose(pose)
    if bad is not None:
        return all_refused(len(given), bad)
    exact = locate_exactly(pose, camera, given, noise, config)
    off_vertical, heading = view_angles(pose.enu_from_camera)
    offsets, below = ground_offsets(pose.height, off_vertical, heading, camera, given)
    north_deg = offsets[:, 1] / METRES_PER_DEGREE
    east_deg = offsets[:, 0] / (METRES_PER_DEGREE * math.cos(pose.latitude))
    latitude = pose.latitude + np.radians(north_deg)
    longitude = pose.longitude + np.radians(east_deg)
    ranges = np.hypot(pose.height, np.hypot(offsets[:, 0], offsets[:, 1]))
    # Its own range is checked, too: a flat Earth has positions beyond the poles.
    limit = (config or EstimatorConfig()).surface.max_range
    near = (ranges <= limit) & (np.abs(latitude) <= 0.5 * math.pi)
    reasons = tuple(
        reason or _refusal(bool(seen), bool(close))
        for reason, seen, close in zip(exact.reasons, below, near, strict=True)
    )
    return mask_refused(
        WaterPoints(
            latitude,
            np.where(np.abs(longitude) > math.pi, wrap_angle(longitude), longitude),
            exact.altitude,
            offsets,
            ranges,
            exact.covariance_white,
            exact.covariance_slow,
            given,
            reasons,
        )
    )


def _refusal(below: bool, near: bool) -> Reason | None:
    """Return why the equations give no position."""
    if not below:
        return Reason.ABOVE_HORIZON
    return None if near else Reason.OUT_OF_RANGE
