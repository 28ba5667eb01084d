# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a camera that stays cannot know, and what one that moves can."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.filter.linearization import (
    CameraView,
    by_angles,
    by_platform,
    relinearize,
)
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.measurement_model import state_jacobian
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel

MODEL = PlatformModel(Noise(correlation_time_s=1e12), "earth")
CAMERA = CameraModel(
    1280, 720, "plumb_bob", np.array([[900.0, 0, 640.0], [0, 900.0, 360.0], [0, 0, 1.0]])
)


def sight(place: tuple[float, float, float]) -> CameraView:
    pose = MapPose(np.array(place), matrix_from_rpy(0.0, math.radians(50), math.pi / 2))
    return CameraView.of(CAMERA, pose, np.zeros(6), 0.0)


def known_platform(speed_mps: float) -> np.ndarray:
    """Return sigmas of the platform's errors over those before, after 10 s of noisy images."""
    rng, joint = np.random.default_rng(4), JointState(MODEL.stationary(None))
    swimmer, velocity = np.array([-4.0, 24.0]), np.array([0.9, -0.4])
    motion = MotionModel(0.05, 0.75)
    for k in range(100):
        if k:
            joint.predict(0.1, MODEL.decay(0.1), MODEL.stationary(None), motion)
        swimmer = swimmer + 0.1 * velocity
        seen = sight((0.1 * k * speed_mps, 0.0, 30.0))
        pixels = linearise(seen, np.zeros(COUNT), swimmer[None]).pixels + rng.normal(0.0, 2.0, 2)
        if not k:
            relinearize(joint, seen)
            start = swimmer[None] + 0.3
            white = 0.01 * np.eye(2)[None]
            joint.add(np.arange(1), start, by_platform(joint, start), white, 0.75)
        else:
            correct(joint, np.arange(1), pixels, seen, MODEL)
    ratio: np.ndarray = np.sqrt(np.diag(joint.covariance)[:6] / np.diag(MODEL.stationary(None))[:6])
    return ratio


def test_a_camera_that_stays_learns_nothing_of_itself_from_a_robot_that_swims():
    np.testing.assert_allclose(known_platform(0.0), 1.0, atol=1e-9)


def test_a_camera_that_flies_past_learns():
    sigmas = known_platform(8.0)
    assert sigmas[:2] == pytest.approx([1.0, 1.0], abs=1e-9)  # a GNSS offset nobody can see
    assert sigmas[3] < 0.7  # roll
    assert sigmas[5] < 0.98  # heading


def test_a_robot_seems_farther_and_faster_by_the_same_share():
    """Derivatives of places, and in their last rows how these change with the robot's motion."""
    offsets, velocities = np.array([[3.0, 20.0, -30.0], [-8.0, 2.0, -12.0]]), np.array(
        [[0.5, -0.3], [0.2, 0.7]]
    )  # fmt: skip
    step = 1e-4
    moved = offsets + step * np.column_stack([velocities, np.zeros(2)])
    here = state_jacobian(np.hstack([offsets, velocities]))
    difference = (state_jacobian(np.hstack([moved, velocities]))[:, :2] - here[:, :2]) / step
    np.testing.assert_allclose(here[:, 2:], difference, atol=1e-3)
    lifted = here[:, :, 2]  # 1 m higher, 30 m up: all a thirtieth longer
    np.testing.assert_allclose(lifted[0], [*offsets[0, :2] / 30.0, *velocities[0] / 30.0])


def test_a_robot_that_begins_with_an_image_is_carried_by_its_angles_like_those_before():
    joint, places = JointState(MODEL.stationary(None)), np.array([[-4.0, 24.0], [3.0, 27.0]])
    seen = sight((0.0, 0.0, 30.0))
    relinearize(joint, seen)
    white = np.tile(0.01 * np.eye(2), (2, 1, 1))
    joint.add(np.arange(2), places, by_platform(joint, places), white, 0.75)
    both = np.arange(2)
    as_new = by_angles(joint, both)
    relinearize(joint, sight((0.0, 0.0, 30.0)))
    np.testing.assert_allclose(as_new, by_angles(joint, both), rtol=1e-9)
    assert np.abs(as_new).max() > 1.0
