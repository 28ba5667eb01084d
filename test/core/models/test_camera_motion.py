# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's motion as predicted from its past, and orientations that jump."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.models.camera_motion import CameraMotion

STEP_S = 0.1
UP = np.array([0.0, 0.0, 1.0])


def _jumps(degrees):
    """Return by image the yaws, deg, by which an orientation jumped, of measured yaws, deg."""
    motion, found = CameraMotion(), {}
    for i, yaw in enumerate(degrees):
        pose = MapPose(np.zeros(3), rotation_matrix(np.radians(yaw) * UP))
        motion.update(pose, STEP_S if i else 0.0)
        if motion.jump is not None:
            found[i] = round(float(np.degrees(motion.jump @ UP)))
    return found


@pytest.mark.parametrize(
    ("degrees", "jumps"),
    [
        ([0.0] * 20, {}),
        ([6.0 * i for i in range(40)], {}),  # 60 deg/s
        ([0.0] * 20 + [17.0 * i for i in range(9)] + [136.0] * 20, {}),  # begins and ends at once
        ([0.0] * 20 + [30.0] * 20, {20: 30}),
        ([0.0] * 20 + [30.0] + [0.0] * 20, {20: 30, 21: -30}),
        ([0.0] * 20 + [30.0] * 30 + [0.0] * 20, {20: 30, 50: -30}),
        ([5.0 * i for i in range(20)] + [5.0 * i - 45.0 for i in range(20, 40)], {20: -45}),
        ([0.0, 0.0, 40.0, 40.0], {2: 40}),
        ([0.0] * 20 + [15.0] * 20, {}),  # 10 deg, and 9 deg for a tenth of a second, are allowed
    ],
    ids=["stays", "turns", "fast", "jumps", "spike", "away and back", "while turning", "at once",
         "small"],
)  # fmt: skip
def test_an_orientation_that_jumps_is_distinguished_from_a_camera_that_turns(degrees, jumps):
    assert _jumps(degrees) == jumps


def _height_jumps(heights):
    """Return by image the jumps, m, of measured heights, m."""
    motion, found = CameraMotion(), {}
    for i, height in enumerate(heights):
        motion.update(MapPose(height * UP, np.eye(3)), STEP_S if i else 0.0)
        if motion.height_jump:
            found[i] = round(motion.height_jump, 1)
    return found


@pytest.mark.parametrize(
    ("heights", "jumps"),
    [
        ([20.0] * 200, {}),
        ([20.0 + 0.9 * i for i in range(200)], {}),  # 9 m/s
        ([20.0] * 200 + [20.0 + 0.9 * i for i in range(50)] + [64.1] * 20, {}),
        ([20.0] * 200 + [24.0] * 20, {200: 4.0}),
        ([20.0] * 200 + [16.0] * 20 + [20.0] * 20, {200: -4.0, 220: 4.0}),
        ([20.0] * 2 + [24.0] * 20, {}),  # what is usual is not known yet
        ([20.0] * 20 + [24.0] * 20, {20: 4.0}),
        ([20.0 + i % 2 for i in range(200)] + [25.0] * 20, {}),  # steps of 1 m are usual
        ([20.0 + i % 2 for i in range(200)] + [29.0] * 20, {200: 8.0}),
    ],
    ids=[
        "stays",
        "climbs",
        "begins to climb",
        "jumps",
        "back",
        "at once",
        "soon",
        "noise",
        "above noise",
    ],
)
def test_a_height_that_jumps_is_distinguished_from_a_drone_that_climbs(heights, jumps):
    assert _height_jumps(heights) == jumps


def test_a_pose_of_another_time_is_no_jump_of_the_height():
    motion = CameraMotion()
    for i in range(200):
        motion.update(MapPose(20.0 * UP, np.eye(3)), STEP_S if i else 0.0)
    motion.restart(MapPose(30.0 * UP, np.eye(3)))
    assert not motion.height_jump
    motion.update(MapPose(30.0 * UP, np.eye(3)), STEP_S)
    assert not motion.height_jump


def test_after_a_jump_it_goes_on_as_before():
    motion = CameraMotion()
    for i in range(40):
        yaw = np.radians(5.0 * i + (30.0 if i >= 30 else 0.0))
        motion.update(MapPose(np.array([0.2 * i, 0.0, 30.0]), rotation_matrix(yaw * UP)), STEP_S)
    assert motion.rates == pytest.approx([2.0, 0.0, 0.0, *np.radians(50.0) * UP], abs=1e-6)


def test_a_latency_that_is_found_moves_the_pose_and_is_no_jump():
    motion = CameraMotion()
    for i in range(10):
        motion.update(MapPose(np.zeros(3), rotation_matrix(np.radians(5.0 * i) * UP)), STEP_S)
    motion.restart(MapPose(np.zeros(3), rotation_matrix(np.radians(20.0) * UP)))
    motion.update(MapPose(np.zeros(3), rotation_matrix(np.radians(60.0) * UP)), STEP_S)
    assert motion.jump is None


@pytest.mark.parametrize("apart_s", [1e-7, 1e-4, 0.02])
@pytest.mark.parametrize("before", [1, 2, 100])
def test_an_image_right_after_another_one_moves_no_camera(before, apart_s):
    """A stamp may be wrong by a few bits; between the two poses there is only noise."""
    motion, t, noise_m = CameraMotion(), 0.0, 0.02
    times = [STEP_S * i for i in range(before)]
    for i, at in enumerate([*times, times[-1] + apart_s, *(times[-1] + STEP_S * np.arange(1, 4))]):
        position = np.array([3.0 * at + noise_m * (-1) ** i, 0.0, 30.0])
        motion.update(MapPose(position, np.eye(3)), at - t)
        t = at
        assert abs(motion.velocity[0] - 3.0) < 3.0 + 2.5 * noise_m / 0.005
    assert motion.velocity[0] == pytest.approx(3.0, abs=6.0 * noise_m / STEP_S)
