# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the paper's released code computes, errors and all: for comparison only, never to be used.

stevvwen/aerial_gnss (Apache-2.0), described from its formulas. Kept are: C1 the vertical angle in
radians added to degrees; C2 the box's right edge for its middle, and minus its upper edge for the
row; C3 the absolute value that folds a view past straight down forward; C4 arcsin for the bearing,
blind to the sign of D; and the earth-referenced gimbal pitch with the drone's pitch added, and the
drone's heading for the camera's. Not kept: its camera of 36 mm and 20.3 mm (the true focal length
is used), feet, and the scoring with the nearest robot.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import rpy_from_matrix
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]

METRES_PER_DEGREE = 364_000.0 * 0.3048


def locate(
    pose: CameraPose, camera: CameraModel, centers: Array, sizes: Array, body: Array
) -> tuple[Array, Array]:
    """Return latitude and longitude (n,) rad of boxes; NaN where the code would fail.

    Args:
        pose: measured.
        camera: its size and focal lengths count.
        centers: (n, 2) px.
        sizes: (n, 2) px.
        body: (3, 3) drone's body FLU in ENU, measured.
    """
    _, nose_down, yaw = rpy_from_matrix(body)
    forward = pose.enu_from_camera[:, 0]
    gimbal_pitch = math.degrees(math.asin(max(-1.0, min(1.0, float(forward[2])))))
    angle = abs(90.0 + gimbal_pitch - math.degrees(float(nose_down)))  # C3
    heading = 0.5 * math.pi - float(yaw)
    x = centers[:, 0] + 0.5 * sizes[:, 0]  # C2
    y = -(centers[:, 1] - 0.5 * sizes[:, 1])  # C2
    theta_x = np.arctan((x - 0.5 * camera.width) / camera.K[0, 0])
    theta_y = np.arctan((y - 0.5 * camera.height) / camera.K[1, 1])
    ahead = pose.height * np.tan(np.radians(angle + theta_y))  # C1
    aside = np.sqrt(pose.height**2 + ahead**2) * np.tan(theta_x)
    distance = np.sqrt(np.sin(theta_x) ** 2 * pose.height**2 + ahead**2) / np.cos(theta_x)
    with np.errstate(invalid="ignore"):
        bearing = heading + np.arcsin(aside / distance)  # C4
    north = distance * np.cos(bearing) / METRES_PER_DEGREE
    east = distance * np.sin(bearing) / (METRES_PER_DEGREE * math.cos(pose.latitude))
    return pose.latitude + np.radians(north), pose.longitude + np.radians(east)
