# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Three drones that look at the same robots, for tests of their joint state."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel

CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [], [900.0, 0, 640.0, 0, 900.0, 360.0, 0, 0, 1.0]
)
PLACES = np.array([[0.0, 1.0], [3.0, -2.0], [-2.0, 2.0]])
MOTION = MotionModel(0.05, 0.75)
MODELS = [
    PlatformModel(estimator_config({"noise.set": noise}).noise, "earth")
    for noise in ("consumer", "rtk", "consumer")
]
STATIONARY = [model.stationary(None) for model in MODELS]


def sight(drone, shift=0.0):
    """The view of a drone, 15 m up; the three look at the origin from different sides."""
    bearing = 2.1 * drone
    place = np.array([-12.0 * math.cos(bearing) + shift, -12.0 * math.sin(bearing), 15.0])
    rotation = matrix_from_rpy(0.0, math.atan2(15.0, 12.0), bearing)
    return CameraView.of(CAMERA, MapPose(place, np.asarray(rotation)), np.zeros(6), 0.0)
