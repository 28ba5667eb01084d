# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots below the surface: Snell's law against hand figures and the simulator's own crossing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.core.geometry.refraction import submerged_offsets
from aerial_gnss_ros.core.georeferencing.localization import locate, located_jacobian, submerged
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.refraction import apparent_points

CAMERA = CameraModel(
    1280, 720, "plumb_bob", np.array([[850.0, 0, 640], [0, 850, 360], [0, 0, 1]]), np.zeros(5)
)
HEIGHT = 12.0
POSE = CameraPose(0, 0.23, -1.04, HEIGHT, HEIGHT, matrix_from_rpy(0.02, math.radians(35), 0.7))
CENTER = np.array([0.0, 0.0, HEIGHT])


def test_the_error_of_ignoring_it() -> None:
    """1 m deep, 60 deg off nadir: 0.85 m (reference: paper, P13)."""
    ray = np.array([[math.sin(math.radians(60)), 0.0, -0.5]])
    offset, _ = submerged_offsets(ray, np.ones(1))
    assert offset[0] == pytest.approx([0.847, 0.0], abs=1e-3)
    straight_down, _ = submerged_offsets(np.array([[0.0, 0.0, -1.0]]), np.ones(1))
    np.testing.assert_array_equal(straight_down, 0.0)


def test_located_where_the_simulator_put_it() -> None:
    """The simulator solves Snell's crossing from the point up; this goes from the pixel down."""
    rng = np.random.default_rng(4)
    true = np.column_stack([rng.uniform(4, 30, (40, 1)), rng.uniform(-6, 6, (40, 1)),
                            -rng.uniform(0.1, 1.5, (40, 1))])  # fmt: skip
    turn = matrix_from_rpy(0.0, 0.0, 0.7)
    true[:, :2] = true[:, :2] @ turn[:2, :2].T
    seen = apparent_points(CENTER, true) - CENTER
    pixels, inside = CAMERA.project(seen @ POSE.enu_from_camera @ FLU_FROM_OPTICAL)
    inside &= CAMERA.inside(pixels)
    assert inside.sum() > 20
    points = locate(POSE, CAMERA, pixels[inside], Noise(), depths=-true[inside, 2])
    np.testing.assert_allclose(points.east_north, true[inside, :2], atol=2e-3)
    ignored = locate(POSE, CAMERA, pixels[inside], Noise())
    wrong = np.linalg.norm(ignored.east_north - true[inside, :2], axis=1)
    assert wrong.max() > 0.8
    # the pixel without refraction is where the straight ray meets the robot's place
    straight = locate(POSE, CAMERA, points.pixels, Noise())
    np.testing.assert_allclose(straight.east_north, points.east_north, atol=1e-4)


@pytest.mark.parametrize("axis", range(3))
def test_derivatives_by_rotation_and_pixel(axis: int) -> None:
    pixels, depths, step = np.array([[300.0, 200.0], [900.0, 650.0]]), np.array([0.7, 1.4]), 1e-6

    def place(pose: CameraPose, at: np.ndarray) -> np.ndarray:
        return locate(pose, CAMERA, at, Noise(), depths=depths).east_north

    found = submerged(located_jacobian(POSE, CAMERA, pixels), depths)
    turn = np.zeros(3)
    turn[axis] = step
    x, y, z = turn
    small = np.array([[1, -z, y], [z, 1, -x], [-y, x, 1]]) @ POSE.enu_from_camera
    turned = CameraPose(0, 0.23, -1.04, HEIGHT, HEIGHT, small)
    by_rotation = (place(turned, pixels) - place(POSE, pixels)) / step
    np.testing.assert_allclose(by_rotation, found.by_rotation[:, :, axis], rtol=2e-4, atol=2e-3)
    if axis < 2:
        moved = pixels + np.eye(2)[axis] * 1e-3
        by_pixel = (place(POSE, moved) - place(POSE, pixels)) / 1e-3
        np.testing.assert_allclose(by_pixel, found.by_pixel[:, :, axis], rtol=2e-4, atol=1e-6)


def test_unknown_depth_widens_the_ellipse() -> None:
    pixels = np.array([[640.0, 100.0]])
    config = estimator_config({"depth": {"sigma_m": 1.0}})
    known = locate(POSE, CAMERA, pixels, Noise())
    unsure = locate(POSE, CAMERA, pixels, Noise(), config)
    grown = np.trace(unsure.covariance[0] - known.covariance[0])
    direction = located_jacobian(POSE, CAMERA, pixels).directions
    offset, _ = submerged_offsets(direction, np.ones(1))
    assert grown == pytest.approx(float(np.sum(offset**2)), rel=1e-6)


def test_depths_by_class() -> None:
    config = estimator_config({"depth": {"robots_m": 0.3, "classes": ["boat=0", "eel=1.5"]}})
    assert config.depth.of(["aqua", "boat", "eel"]).tolist() == [0.3, 0.0, 1.5]
    with pytest.raises(ConfigError, match=r"aqua=0\.8"):
        estimator_config({"depth": {"classes": ["aqua 1"]}})
