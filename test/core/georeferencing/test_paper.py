# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The paper's method: its own numbers, and each error that is kept or mended."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, yaw_from_heading
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.georeferencing import paper
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Reason

CAMERA = CameraModel.from_focal_length(1082.7, 1920.0, None, 1920, 1080)
NOISE = Noise()
A = (6.7, 59.1, 235.3), (1400, 300)
B = (6.7, 59.1, 235.3), (1400, 850)
C = (50.0, 45.0, 235.3), (1400, 300)


def _pose(height, off_nadir_deg, heading_deg, roll_deg=0.0):
    matrix = matrix_from_rpy(
        math.radians(roll_deg),
        math.radians(90.0 - off_nadir_deg),
        yaw_from_heading(math.radians(heading_deg)),
    )
    place = math.radians(13.1939387), math.radians(-59.6415066)
    return CameraPose(0, *place, height, math.nan, matrix)


def _both(geometry, pixel):
    pose = _pose(*geometry)
    return paper.locate(pose, CAMERA, [pixel], NOISE), locate(pose, CAMERA, [pixel], NOISE)


@pytest.mark.parametrize(
    ("case", "true_range", "lateral"),
    [(A, 21.8, 0.20), (B, 7.2, 0.14), (C, 86.7, 0.90)],
    ids=["A", "B", "C"],
)
def test_only_the_lateral_error_is_left_on_the_plane(case, true_range, lateral):
    ours, exact = _both(*case)
    assert np.hypot(*exact.east_north[0]) == pytest.approx(true_range, abs=0.05)
    error = np.linalg.norm(ours.east_north - exact.east_north)
    assert error == pytest.approx(lateral, abs=0.01)


@pytest.mark.parametrize(("case", "sphere"), [(A, 0.08), (C, 0.31)], ids=["A", "C"])
def test_364000_feet_per_degree_are_a_sphere(case, sphere):
    ours, _ = _both(*case)
    pose = _pose(*case[0])
    length, azimuth, _ = geodesic_inverse(
        pose.latitude, pose.longitude, ours.latitude[0], ours.longitude[0]
    )
    on_globe = length * np.array([math.sin(azimuth), math.cos(azimuth)])
    assert np.linalg.norm(on_globe - ours.east_north[0]) == pytest.approx(sphere, abs=0.02)


def test_the_vertical_angle_has_the_right_sign():
    # A=10, alpha=60, theta_y=+15 deg (lower half): 10 m, where the printed sign gives 37.3 m
    pixels = np.array([[960.0, 540.0 + 1082.7 * math.tan(math.radians(15.0))]])
    offsets, below = paper.ground_offsets(10.0, math.radians(60.0), 0.0, CAMERA, pixels)
    assert below.all()
    assert offsets[0] == pytest.approx([0.0, 10.0], abs=1e-9)


def test_north_moves_latitude_and_east_longitude():
    pose = _pose(10.0, 45.0, 0.0)
    north = paper.locate(pose, CAMERA, [[960, 540]], NOISE)
    assert math.degrees(north.latitude[0] - pose.latitude) == pytest.approx(10.0 / 110947.2)
    assert north.longitude[0] == pytest.approx(pose.longitude)
    east = paper.locate(_pose(10.0, 45.0, 90.0), CAMERA, [[960, 540]], NOISE)
    per_degree = 110947.2 * math.cos(pose.latitude)
    assert math.degrees(east.longitude[0] - pose.longitude) == pytest.approx(10.0 / per_degree)


def test_behind_straight_down_the_bearing_has_its_own_quadrant():
    # P4: the arc tangent would mirror this point by 5.2 m
    ours, exact = _both((10.0, 10.0, 0.0), (1200, 900))
    east, north = ours.east_north[0]
    assert north < 0.0 < east
    assert math.dist(ours.east_north[0], exact.east_north[0]) < 0.15


def test_straight_down_is_where_the_image_says():
    ours, exact = _both((10.0, 0.0, 235.3), (960, 540))
    assert ours.east_north[0] == pytest.approx([0.0, 0.0], abs=1e-9)
    ours, exact = _both((10.0, 0.0, 235.3), (960, 300))
    assert ours.east_north == pytest.approx(exact.east_north, abs=1e-3)


def test_roll_and_the_principal_point_stay_ignored():
    # P5: 2.7 m for one degree of roll at h=50, alpha=60, u=1700
    level, rolled = _pose(50.0, 60.0, 10.0), _pose(50.0, 60.0, 10.0, roll_deg=1.0)
    pixel = [[1700, 540]]
    ours = [paper.locate(pose, CAMERA, pixel, NOISE).east_north for pose in (level, rolled)]
    assert ours[0] == pytest.approx(ours[1], abs=1e-9)
    exact = [locate(pose, CAMERA, pixel, NOISE).east_north for pose in (level, rolled)]
    assert np.linalg.norm(exact[0] - exact[1]) == pytest.approx(2.7, abs=0.1)
    shifted = replace(CAMERA, K=CAMERA.K + np.array([[0, 0, 30], [0, 0, 0], [0, 0, 0]]))
    assert paper.locate(level, shifted, pixel, NOISE).east_north == pytest.approx(ours[0])


def test_above_the_horizon_nothing_is_reported():
    pose = _pose(50.0, 80.0, 0.0)
    got = paper.locate(pose, CAMERA, [[960, 100], [960, 900]], NOISE)
    assert got.reasons == (Reason.ABOVE_HORIZON, None)
    assert np.isnan(got.latitude).tolist() == [True, False]
    _, below = paper.ground_offsets(50.0, math.radians(80), 0.0, CAMERA, np.array([[960.0, 100.0]]))
    assert not below[0]


def test_a_bad_pose_is_refused():
    got = paper.locate(replace(_pose(50.0, 45.0, 0.0), height=-1.0), CAMERA, [[960, 540]], NOISE)
    assert got.reasons == (Reason.BAD_HEIGHT,)


@pytest.mark.parametrize("off_nadir_deg", [59.1, 0.0, -12.0])
def test_the_cameras_angle_and_heading_come_from_its_orientation(off_nadir_deg):
    matrix = _pose(5.0, off_nadir_deg, 235.3).enu_from_camera
    off_vertical, heading = paper.view_angles(matrix)
    assert math.degrees(off_vertical) == pytest.approx(off_nadir_deg, abs=1e-9)
    assert math.degrees(heading) % 360.0 == pytest.approx(235.3, abs=1e-9)


def test_places_beyond_the_poles_are_refused():
    """The width of a damaged CameraInfo put the image's middle a thousand million pixels away."""
    wide = replace(CAMERA, width=1_362_949_160)
    for heading_deg in (0.0, 90.0, 180.0, 270.0):
        found = paper.locate(_pose(20.0, 45.0, heading_deg), wide, [[960.0, 600.0]], NOISE)
        assert found.reasons == (Reason.OUT_OF_RANGE,)
        assert np.isnan(found.latitude[0])


def test_longitudes_go_on_beyond_the_antimeridian():
    pose = replace(_pose(50.0, 45.0, 90.0), longitude=math.radians(179.9999))
    found = paper.locate(pose, CAMERA, [[960.0, 540.0]], NOISE)
    assert found.longitude[0] == pytest.approx(-math.pi, abs=1e-4)
