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

    def corrected(self, change: Array) -> MapPose:
        """Return the pose changed by (6,): a shift, m, and a rotation vector, rad, in `map`."""
        return MapPose(self.position + change[:3], rotation_matrix(change[3:]) @ self.rotation)
