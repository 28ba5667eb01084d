# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera over three robots, for tests of the joint filter."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel

MODEL = PlatformModel(Noise(latency_s=0.3), "earth")
CAMERA = CameraModel(
    1280, 720, "plumb_bob", np.array([[900.0, 0, 640.0], [0, 900.0, 360.0], [0, 0, 1.0]])
)
PLACES = np.array([[-3.0, 20.0], [5.0, 24.0], [1.0, 31.0]])


def sight() -> CameraView:
    pose = MapPose(np.array([0.0, 0.0, 30.0]), matrix_from_rpy(0.0, math.radians(50), math.pi / 2))
    return CameraView.of(CAMERA, pose, np.array([2.0, 1.0, 0, 0, 0, 0.05]), 0.0)


def crowd() -> JointState:
    """Three robots with a covariance that is nowhere zero."""
    joint = JointState(MODEL.stationary(None))
    by_platform = np.random.default_rng(3).normal(size=(3, 2, COUNT))
    joint.add(np.arange(3), PLACES, by_platform, np.tile(0.04 * np.eye(2), (3, 1, 1)), 0.7)
    joint.mean[:] += 0.01 * np.arange(len(joint.mean))
    return joint
