# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""First-order uncertainty, straight down and at 45 deg, where it can be worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.water_surface import SurfaceView
from aerial_gnss_ros.core.georeferencing.covariance import (
    covariances,
    elevation_sigma,
    ray_points,
    uncertainty,
    white_rotation,
)
from aerial_gnss_ros.core.values.camera_pose import CameraPose

F, HEIGHT = 1000.0, 30.0
CAMERA = CameraModel.from_camera_info(
    1281, 721, "plumb_bob", [], [F, 0, 640.0, 0, F, 360.0, 0, 0, 1.0]
)
NONE = dict.fromkeys(
    ("gnss_offset_m", "gnss_white_m", "heading_deg", "gimbal_pitch_deg", "gimbal_roll_deg",
     "height_m", "attitude_white_deg", "gimbal_white_deg", "height_white_m", "box_center_px"), 0.0,
)  # fmt: skip


def _pose(pitch_deg, covariance=None):
    """A camera over the equator that looks north, so far down."""
    matrix = matrix_from_rpy(0.0, math.radians(pitch_deg), math.pi / 2)
    return CameraPose(0, 0.0, 0.0, HEIGHT, HEIGHT, matrix, covariance)


def _sigmas(pitch_deg, pixel=(640.0, 360.0), **noise):
    """Return white and slow sigmas East, North of one pixel by what is stated, m."""
    pose = _pose(pitch_deg)
    points = ray_points(SurfaceView(pose), CAMERA, np.array([pixel]))
    both = covariances(points, uncertainty(pose, Noise(**{**NONE, **noise}), "earth"))
    return [np.sqrt(np.maximum(one[0].diagonal(), 0.0)) for one in both]


ONE_DEG = math.radians(1.0)


@pytest.mark.parametrize(
    ("pitch_deg", "noise", "white", "slow"),
    [
        (90, {"gimbal_pitch_deg": 1.0}, (0, 0), (0, HEIGHT * ONE_DEG)),
        (90, {"gimbal_roll_deg": 1.0}, (0, 0), (HEIGHT * ONE_DEG, 0)),
        (90, {"heading_deg": 1.0}, (0, 0), (0, 0)),
        (90, {"height_m": 1.0}, (0, 0), (0, 0)),
        (90, {"gimbal_white_deg": 1.0}, (HEIGHT * ONE_DEG, HEIGHT * ONE_DEG), (0, 0)),
        (90, {"box_center_px": 2.0}, (2 * HEIGHT / F, 2 * HEIGHT / F), (0, 0)),
        (45, {"gimbal_pitch_deg": 1.0}, (0, 0), (0, 2 * HEIGHT * ONE_DEG)),  # h / sin²
        (45, {"heading_deg": 1.0}, (0, 0), (HEIGHT * ONE_DEG, 0)),
        (45, {"gimbal_roll_deg": 1.0}, (0, 0), (HEIGHT * ONE_DEG, 0)),  # about the level view
        (45, {"height_m": 1.0}, (0, 0), (0, 1.0)),
        (45, {"height_white_m": 1.0}, (0, 1.0), (0, 0)),
        (45, {"box_center_px": 1.0}, (HEIGHT * math.sqrt(2) / F, 2 * HEIGHT / F), (0, 0)),
        (45, {"gnss_offset_m": 2.0}, (0, 0), (2.0, 2.0)),
        (45, {"gnss_white_m": 2.0}, (2.0, 2.0), (0, 0)),
    ],
)
def test_each_error_moves_the_point_as_geometry_says(pitch_deg, noise, white, slow):
    found = _sigmas(pitch_deg, **noise)
    np.testing.assert_allclose(found[0], white, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(found[1], slow, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_derivatives_by_rotation_are_differences(axis):
    from scipy.spatial.transform import Rotation

    pose, pixels = _pose(50.0), np.array([[100.0, 200.0], [900.0, 600.0]])
    ends = []
    for sign in (1.0, -1.0):
        turn = Rotation.from_rotvec(sign * 1e-6 * np.eye(3)[axis]).as_matrix()
        turned = CameraPose(0, 0.0, 0.0, HEIGHT, HEIGHT, turn @ pose.enu_from_camera)
        ends.append(ray_points(SurfaceView(turned), CAMERA, pixels).offsets[:, :2])
    points = ray_points(SurfaceView(pose), CAMERA, pixels)
    np.testing.assert_allclose(
        points.by_rotation[:, :, axis], (ends[0] - ends[1]) / 2e-6, rtol=1e-5, atol=1e-3
    )


@pytest.mark.parametrize(
    ("noise", "sigma_deg"),
    [
        ({"gimbal_pitch_deg": 1.0}, 1.0),
        ({"gimbal_white_deg": 1.0}, 1.0),
        ({"heading_deg": 1.0}, 0.0),
        ({"gimbal_roll_deg": 1.0}, 0.0),
        ({"box_center_px": 10.0}, math.degrees(10.0 / F)),
    ],
)
def test_what_tilts_the_view_makes_its_elevation_unsure(noise, sigma_deg):
    pose = _pose(30.0)
    points = ray_points(SurfaceView(pose), CAMERA, np.array([[640.0, 360.0]]))
    known = uncertainty(pose, Noise(**{**NONE, **noise}), "earth")
    assert math.degrees(elevation_sigma(points, known)[0]) == pytest.approx(sigma_deg, abs=1e-9)


def test_a_fix_may_bring_its_own_covariance():
    own = np.array([[1.0, 0.5], [0.5, 3.0]])
    noise = Noise(gnss_offset_m=2.0)
    found = uncertainty(_pose(45.0, own), noise, "earth").position_slow
    np.testing.assert_array_equal(found, own)
    bad = uncertainty(_pose(45.0, np.full((2, 2), np.nan)), noise, "earth").position_slow
    np.testing.assert_array_equal(bad, 4.0 * np.eye(2))


@pytest.mark.parametrize(
    ("reference", "variances"),
    [("earth", (4, 4, 4)), ("heading", (4, 4, 13)), ("body", (13, 13, 13)), ("fixed", (9, 9, 9))],
)
def test_white_rotation_is_that_of_the_sensors_in_use(reference, variances):
    from aerial_gnss_ros.core.geometry.gimbal import Reference

    noise = Noise(gimbal_white_deg=2.0, attitude_white_deg=3.0)
    found = white_rotation(noise, Reference(reference))
    np.testing.assert_allclose(found, np.array(variances) * ONE_DEG**2)
