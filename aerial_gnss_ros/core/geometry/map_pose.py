# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera's pose in the frame `map`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import LocalMap, ecef_of_places, enu_axes
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MapPose:
    """A camera in `map`.

    Attributes:
        position: (3,) East, North, Up, m.
        rotation: (3, 3) camera FLU in `map`.
    """

    position: Array
    rotation: Array

    @staticmethod
    def of(pose: CameraPose, local: LocalMap) -> MapPose:
        """Return a camera's pose in `map`, with the water at the origin's altitude."""
        (place,) = ecef_of_places([(pose.latitude, pose.longitude, pose.height)])
        axes = local.axes
        turn = axes @ enu_axes(pose.latitude, pose.longitude).T
        return MapPose(axes @ (place - local.origin), turn @ pose.enu_from_camera)

    @property
    def optical(self) -> Array:
        """(3, 3) optical frame in `map`."""
        turned: Array = self.rotation @ FLU_FROM_OPTICAL
        return turned

    def corrected(self, errors: Array, axes: Array) -> MapPose:
        """Return the pose corrected by the platform's errors (6,) or more.

        Args:
            errors: East, North, height (m), roll, pitch, heading (rad).
            axes: (3, 3) of the last three, see `gimbal.error_axes`.
        """
        turn = rotation_matrix(axes @ errors[3:6])
        return MapPose(self.position + errors[:3], turn @ self.rotation)
