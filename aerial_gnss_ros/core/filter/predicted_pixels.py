# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pixels at which robots are predicted to be seen, with all derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.models.measurement_model import pose_jacobian

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Linear:
    """Linearised measurement of m robots' pixels.

    Attributes:
        pixels: (m, 2) predicted.
        by_place: (m, 2, 2) derivative by the robots' East, North, px/m.
        by_platform: (m, 2, 9) by the platform's errors.
        by_pose: (m, 2, 6) by the pose's white noise.
        seen: (m,) False if the camera model has no pixel for the robot.
    """

    pixels: Array
    by_place: Array
    by_platform: Array
    by_pose: Array
    seen: NDArray[np.bool_]


def linearise(
    sight: CameraView, errors: Array, positions: Array, by_pose: Array | None = None
) -> Linear:
    """Return predicted pixels and all derivatives at an estimate.

    Args:
        sight: the camera.
        errors: (9,) estimate of the platform's errors.
        positions: (m, 2) estimate of the robots' East, North, m.
        by_pose: (m, 2, 6) `pose_jacobian` to be used; None: at the estimate itself.
    """
    pose = sight.pose(errors)
    offsets = on_water_surface(positions) - pose.position
    optical = pose.rotation @ FLU_FROM_OPTICAL
    pixels, by_point, seen = sight.camera.project_with_jacobian(offsets @ optical)
    by_place = (by_point @ optical.T)[:, :, :2]
    seen = seen & (offsets[:, 2] < 0.0)
    if by_pose is None:
        by_pose = pose_jacobian(offsets)
    by_pose = -by_place @ by_pose
    return Linear(pixels, by_place, by_pose @ sight.by_errors, by_pose, seen)
