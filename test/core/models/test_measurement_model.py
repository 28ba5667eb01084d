# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Predicted pixels and all derivatives of the joint filter against `locate` and differences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import LocalMap, geodetic_from_enu, on_water_surface
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix, rotation_vector
from aerial_gnss_ros.core.georeferencing.localization import located_jacobian
from aerial_gnss_ros.core.models.measurement_model import on_water, pose_jacobian
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import MapDatum

LOCAL = LocalMap(MapDatum(math.radians(48.0), math.radians(11.0), 0.0))
MATRIX = np.array([[900.0, 0, 655.0], [0, 910.0, 350.0], [0, 0, 1.0]])
TURN = matrix_from_rpy(0.01, -0.02, 0.03)
CAMERAS = {
    "pinhole": CameraModel(1280, 720, "plumb_bob", MATRIX),
    "plumb_bob": CameraModel(
        1280, 720, "plumb_bob", MATRIX, np.array([-0.1, 0.02, 1e-3, -5e-4, 0.01])
    ),
    "equidistant": CameraModel(
        1280, 720, "equidistant", MATRIX, np.array([0.02, -0.01, 0.003, 0.0])
    ),
    "rectified": CameraModel(1280, 720, "plumb_bob", MATRIX, rectified=True, R=TURN),
}
PIXELS = np.array([[200.0, 120.0], [655.0, 350.0], [1100.0, 640.0], [640.0, 700.0]])
ERRORS = np.array([0.4, -0.3, 0.2, 0.004, -0.006, 0.02, 0.01, -0.015, 0.1])
RATES = np.array([3.0, -4.0, 0.5, 0.01, -0.02, 0.15])


def camera_pose(east: float = 700.0, north: float = -500.0, height: float = 30.0) -> CameraPose:
    latitude, longitude, _ = geodetic_from_enu(
        east, north, height, LOCAL.datum.latitude, LOCAL.datum.longitude, 0.0
    )
    rotation = matrix_from_rpy(0.02, math.radians(50.0), 0.7)
    return CameraPose(0, float(latitude), float(longitude), height, height, rotation)


def sight(camera: CameraModel, applied: float = 0.0) -> CameraView:
    pose = MapPose.of(camera_pose(), LOCAL)
    return CameraView.of(camera, pose, RATES, applied)


def places(camera: CameraModel) -> np.ndarray:
    offsets = located_jacobian(camera_pose(), camera, PIXELS).offsets
    pose = MapPose.of(camera_pose(), LOCAL)
    turn = pose.rotation @ camera_pose().enu_from_camera.T
    return on_water(pose, offsets @ turn.T)


@pytest.mark.parametrize("name", CAMERAS)
def test_predicted_pixels_are_those_of_the_exact_chain(sea, name):
    camera = CAMERAS[name]
    where = places(camera)
    predicted = linearise(sight(camera), np.zeros(COUNT), where)
    np.testing.assert_allclose(predicted.pixels, PIXELS, atol=1e-3)
    latitude, longitude = LOCAL.places(where)
    exact, _ = sea.project_to_image(camera_pose(), camera, latitude, longitude)
    np.testing.assert_allclose(predicted.pixels, exact, atol=1e-3)
    assert predicted.seen.all()


@pytest.mark.parametrize("name", CAMERAS)
def test_derivatives_by_place_and_platform_are_differences_of_the_pixels(name):
    camera = CAMERAS[name]
    seen, where = sight(camera), places(camera)

    def pixels(errors, positions):
        return linearise(seen, errors, positions).pixels

    # Small errors, as the axes do not turn with the camera: the derivative is exact at zero.
    linear = linearise(seen, np.zeros(COUNT), where)
    for column in range(COUNT):
        step = np.zeros(COUNT)
        step[column] = 1e-5
        difference = (pixels(step, where) - pixels(-step, where)) / 2e-5
        scale = np.abs(linear.by_platform[:, :, column]).max()
        np.testing.assert_allclose(linear.by_platform[:, :, column], difference, atol=3e-4 * scale)
    for column in range(2):
        step = np.zeros(2)
        step[column] = 1e-3
        difference = (
            pixels(np.zeros(COUNT), where + step) - pixels(np.zeros(COUNT), where - step)
        ) / 2e-3
        np.testing.assert_allclose(linear.by_place[:, :, column], difference, atol=5e-3)


def test_the_pose_jacobian_agrees_with_that_of_single_points():
    camera = CAMERAS["plumb_bob"]
    points = located_jacobian(camera_pose(), camera, PIXELS)
    mine = pose_jacobian(points.offsets)
    reach = np.abs(points.offsets).max()
    np.testing.assert_allclose(mine[:, :, 3:], points.by_rotation, atol=1e-3 * reach)
    np.testing.assert_allclose(mine[:, :, 2], points.by_height, atol=1e-3)


def test_corrections_and_their_axes_mean_the_same_as_in_single_points():
    """Taking errors out of the pose puts a robot where `locate` puts it from the true pose."""
    camera = CAMERAS["pinhole"]
    seen, true = sight(camera), places(camera)
    wrong = linearise(seen, np.zeros(COUNT), true).pixels
    right = linearise(seen, ERRORS * ([1] * LATENCY + [0]), true).pixels
    assert np.abs(wrong - right).max() > 5.0
    pose = seen.pose(ERRORS * ([1] * LATENCY + [0]))
    optical = (on_water_surface(true) - pose.position) @ pose.optical
    np.testing.assert_allclose(optical[:, :2] / optical[:, 2:] @ MATRIX[:2, :2].T + MATRIX[:2, 2],
                               right, atol=1e-9)  # fmt: skip


def test_an_applied_latency_is_not_applied_twice():
    camera = CAMERAS["pinhole"]
    where = places(camera)
    late = np.array([0.0] * LATENCY + [0.4])
    here = linearise(sight(camera, applied=0.4), late, where).pixels
    np.testing.assert_allclose(here, linearise(sight(camera), np.zeros(COUNT), where).pixels)
    moved = linearise(sight(camera), late, where).pixels
    pose = sight(camera).measured
    before = type(pose)(
        pose.position - 0.4 * RATES[:3], rotation_matrix(-0.4 * RATES[3:]) @ pose.rotation
    )
    earlier = CameraView.of(camera, before, RATES, 0.0)
    np.testing.assert_allclose(moved, linearise(earlier, np.zeros(COUNT), where).pixels, atol=1e-9)


@pytest.mark.parametrize(
    "vector", [[0.0, 0.0, 0.0], [1e-5, 0, -2e-5], [0.3, -0.2, 1.0], [0, 3, 0], [0, 0, np.pi]]
)
def test_rotation_vectors_and_matrices(vector):
    matrix = rotation_matrix(np.array(vector, dtype=float))
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rotation_vector(matrix), vector, atol=1e-9)


def test_a_robot_behind_the_camera_is_not_seen():
    behind = MapPose.of(camera_pose(), LOCAL).position[:2] - [200.0, 200.0]
    assert not linearise(sight(CAMERAS["pinhole"]), np.zeros(COUNT), behind[None]).seen.any()
