# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pixels to positions: round trips, derivatives, covariance by Monte Carlo, refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, yaw_from_heading
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.georeferencing.covariance import uncertainty
from aerial_gnss_ros.core.georeferencing.localization import (
    locate,
    located_jacobian,
)
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Reason

K = [[1082.7, 0.0, 960.0], [0.0, 1082.7, 540.0], [0.0, 0.0, 1.0]]
CAMERAS = [
    CameraModel.from_camera_info(1920, 1080, model, d, K)
    for model, d in (
        ("plumb_bob", []),
        ("plumb_bob", [-0.12, 0.03, 1e-3, -5e-4, 0.0]),
        ("rational_polynomial", [0.5, 0.1, 1e-3, -5e-4, 0.02, 0.6, 0.2, 0.01]),
        ("equidistant", [0.02, -0.01, 0.003, -0.001]),
    )
]
PINHOLE = CAMERAS[0]
NOISE = Noise()


def geodesic_direct(latitude, longitude, azimuth, distance):
    """Latitude, longitude (rad) reached from a place on an azimuth (rad) after so many metres."""
    lon, lat, _ = Geod(ellps="WGS84").fwd(longitude, latitude, azimuth, distance, radians=True)
    return lat, lon


def _pose(height, off_nadir_deg, heading_deg, *, altitude=math.nan, lat=13.19, lon=-59.64, roll=0):
    matrix = matrix_from_rpy(
        math.radians(roll),
        math.radians(90.0 - off_nadir_deg),
        yaw_from_heading(math.radians(heading_deg)),
    )
    return CameraPose(0, math.radians(lat), math.radians(lon), height, altitude, matrix)


@pytest.mark.parametrize(
    ("height", "off_nadir", "heading", "ahead"),
    [(10.0, 0.0, 0.0, 0.0), (10.0, 60.0, 0.0, 17.3205), (30.0, 45.0, 90.0, 30.0)],
)
def test_the_image_centre_lies_h_tan_alpha_ahead(height, off_nadir, heading, ahead):
    got = locate(_pose(height, off_nadir, heading), PINHOLE, [[960, 540]], NOISE)
    there = ahead * math.sin(math.radians(heading)), ahead * math.cos(math.radians(heading))
    assert got.east_north[0] == pytest.approx(there, abs=3e-4)
    assert got.range_m[0] == pytest.approx(height / math.cos(math.radians(off_nadir)), abs=1e-3)


@pytest.mark.parametrize(
    ("pixel", "distance"), [((1400, 300), 21.829), ((1400, 850), 7.227)], ids=["A", "B"]
)
def test_the_papers_test_geometry_has_its_true_ranges(pixel, distance):
    pose = _pose(6.7, 59.1, 235.3)
    got = locate(pose, PINHOLE, [pixel], NOISE)
    assert np.hypot(*got.east_north[0]) == pytest.approx(distance, abs=1e-3)
    length, azimuth, _ = geodesic_inverse(
        pose.latitude, pose.longitude, got.latitude[0], got.longitude[0]
    )
    assert length == pytest.approx(distance, abs=1e-3)
    east, north = got.east_north[0]
    assert math.cos(azimuth - math.atan2(east, north)) == pytest.approx(1.0, abs=1e-10)


poses = st.builds(
    _pose,
    st.floats(2.0, 120.0),
    st.floats(-40.0, 70.0),
    st.floats(0.0, 360.0),
    altitude=st.one_of(st.just(math.nan), st.floats(-50.0, 200.0)),
    lat=st.floats(-75.0, 75.0),
    lon=st.floats(-180.0, 180.0),
    roll=st.floats(-20.0, 20.0),
)
pixels = st.tuples(st.floats(0.0, 1919.0), st.floats(0.0, 1079.0))


@settings(max_examples=300, deadline=None)
@given(poses, st.sampled_from(CAMERAS), pixels)
def test_what_is_located_is_seen_at_its_pixel_and_within_a_millimetre(sea, pose, camera, pixel):
    got = locate(pose, camera, [pixel], NOISE)
    if not got.valid[0]:
        return
    back, seen = sea.project_to_image(pose, camera, got.latitude, got.longitude)
    assert seen[0]
    assert back[0] == pytest.approx(pixel, abs=1e-3)
    again = locate(pose, camera, back, NOISE)
    moved, _, _ = geodesic_inverse(
        got.latitude[0], got.longitude[0], again.latitude[0], again.longitude[0]
    )
    assert moved < 1e-3


def test_a_place_that_is_projected_is_located_there(sea):
    pose = _pose(40.0, 55.0, 310.0, lon=179.9999)  # the view crosses the antimeridian
    lat, lon = geodesic_direct(pose.latitude, pose.longitude, math.radians(312.0), 55.0)
    seen_at, seen = sea.project_to_image(pose, CAMERAS[1], lat, lon)
    assert seen.all()
    got = locate(pose, CAMERAS[1], seen_at, NOISE)
    assert geodesic_inverse(lat, lon, got.latitude[0], got.longitude[0])[0] < 1e-3


def test_places_behind_the_camera_are_not_in_the_image(sea):
    pose = _pose(10.0, 80.0, 0.0)
    behind = geodesic_direct(pose.latitude, pose.longitude, math.pi, 500.0)
    assert not sea.project_to_image(pose, PINHOLE, *behind)[1][0]


def _moved(pose, camera, given, *, turn=None, up=0.0, east=0.0, north=0.0):
    """East, North of the located points from the first pose's camera after a small change."""
    lat, lon = pose.latitude, pose.longitude
    lat, lon = geodesic_direct(lat, lon, math.atan2(east, north), math.hypot(east, north))
    matrix = pose.enu_from_camera if turn is None else turn @ pose.enu_from_camera
    changed = replace(
        pose, latitude=lat, longitude=lon, height=pose.height + up,
        altitude=pose.altitude + up, enu_from_camera=matrix,
    )  # fmt: skip
    got = located_jacobian(changed, camera, given).offsets[:, :2]
    return got + np.array([east, north])


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: f"{camera.model} {camera.D.size}")
def test_derivatives_are_those_of_finite_differences(camera):
    pose = _pose(25.0, 50.0, 200.0, altitude=12.0, roll=8.0)
    given = np.array([[960.0, 540.0], [300.0, 400.0], [1700.0, 900.0]])
    points = located_jacobian(pose, camera, given)

    def slope(step, plus, minus):
        return (plus - minus) / (2.0 * step)

    for axis in range(3):
        w = np.zeros(3)
        w[axis] = 1e-5
        turn, back = Rotation.from_rotvec(w).as_matrix(), Rotation.from_rotvec(-w).as_matrix()
        expected = slope(
            1e-5, _moved(pose, camera, given, turn=turn), _moved(pose, camera, given, turn=back)
        )
        assert points.by_rotation[:, :, axis] == pytest.approx(expected, rel=1e-5, abs=1e-4)
    for axis, e in enumerate(np.eye(2) * 1e-2):
        expected = slope(1e-2, _moved(pose, camera, given + e), _moved(pose, camera, given - e))
        assert points.by_pixel[:, :, axis] == pytest.approx(expected, rel=1e-5, abs=1e-7)
    expected = slope(
        0.01, _moved(pose, camera, given, up=0.01), _moved(pose, camera, given, up=-0.01)
    )
    assert points.by_height == pytest.approx(expected, abs=1e-5)
    for axis, name in enumerate(("east", "north")):
        plus = _moved(pose, camera, given, **{name: 1.0})
        minus = _moved(pose, camera, given, **{name: -1.0})
        column = np.broadcast_to(points.by_position[:, axis], plus.shape)
        assert slope(1.0, plus, minus) == pytest.approx(column, abs=1e-4)


@pytest.mark.parametrize(
    ("height", "off_nadir", "pixel", "reference"),
    [
        (7.0, 60.0, (960, 540), "earth"),
        (30.0, 0.0, (1300, 200), "heading"),
        (30.0, 45.0, (300, 800), "body"),
        (50.0, 60.0, (1500, 500), "earth"),
    ],
)
def test_covariance_agrees_with_monte_carlo(height, off_nadir, pixel, reference):
    pose = _pose(height, off_nadir, 120.0, roll=3.0)
    config = estimator_config({"gimbal.reference": reference})
    got = locate(pose, CAMERAS[1], [pixel], NOISE, config)
    white, slow = _sampled(pose, CAMERAS[1], pixel, reference)
    for computed, sampled in ((got.covariance_white[0], white), (got.covariance_slow[0], slow)):
        root = np.linalg.inv(np.linalg.cholesky(sampled))
        ratio = np.linalg.eigvalsh(root @ computed @ root.T)  # 1 and 1 when they are equal
        assert ratio == pytest.approx([1.0, 1.0], abs=0.08)


def _sampled(pose, camera, pixel, reference, count=4000):
    """Covariances of points drawn with the sensors' stated errors, straight from the geometry."""
    rng = np.random.default_rng(7)
    degrees = math.radians(1.0)
    attitude = {"earth": [0, 0, 0], "heading": [0, 0, 0.1], "body": [0.1, 0.1, 0.1]}[reference]
    white = _draw(
        rng, pose, camera, pixel, count,
        turns=rng.normal(size=(count, 3)) * np.hypot(0.03, attitude) * degrees,
        heights=0.03, pixels=2.0, places=0.03,
    )  # fmt: skip
    slow = _draw(
        rng, pose, camera, pixel, count,
        turns=rng.normal(size=(count, 3)) * np.array([0.4, 0.4, 1.5]) * degrees
        @ error_axes(pose.enu_from_camera).T,
        heights=0.3, pixels=0.0, places=1.2,
    )  # fmt: skip
    return np.cov(white.T), np.cov(slow.T)


def _draw(rng, pose, camera, pixel, count, *, turns, heights, pixels, places):
    rays, _ = camera.rays(np.array(pixel) + rng.normal(size=(count, 2)) * pixels)
    flu = np.column_stack([rays[:, 2], -rays[:, 0], -rays[:, 1]]) @ pose.enu_from_camera.T
    enu = Rotation.from_rotvec(turns).apply(flu)
    tall = pose.height + rng.normal(size=count) * heights
    flat = enu[:, :2] / -enu[:, 2:] * tall[:, None]  # a flat sea will do for a few percent
    return flat + rng.normal(size=(count, 2)) * places


def test_the_fixs_own_covariance_replaces_the_noises():
    pose = _pose(10.0, 0.0, 0.0)
    own = np.array([[0.25, 0.1], [0.1, 0.16]])
    pixel = [[960, 540]]
    theirs = locate(pose, PINHOLE, pixel, NOISE).covariance_slow[0]
    ours = locate(replace(pose, fix_covariance=own), PINHOLE, pixel, NOISE).covariance_slow[0]
    assert ours - own == pytest.approx(theirs - 1.44 * np.eye(2))
    broken = replace(pose, fix_covariance=own * np.nan)
    assert locate(broken, PINHOLE, pixel, NOISE).covariance_slow[0] == pytest.approx(theirs)


def test_a_single_frame_reaches_the_published_bounds():
    # geolocation, 2.3: CEP of one frame, consumer without the GNSS term, about 1 / 0.589
    noise = Noise(
        gnss_offset_m=0.0, gnss_white_m=0.0, heading_deg=1.5, gimbal_pitch_deg=0.5,
        gimbal_roll_deg=0.5, height_m=0.5, box_center_px=3.0, height_white_m=0.0,
    )  # fmt: skip
    for height, off_nadir, cep in ((7, 60, 0.71), (30, 30, 0.55), (30, 60, 1.63), (50, 60, 2.54)):
        covariance = locate(_pose(height, off_nadir, 0), PINHOLE, [[960, 540]], noise).covariance[0]
        drawn = np.random.default_rng(1).multivariate_normal([0, 0], covariance, 20000)
        assert np.median(np.hypot(*drawn.T)) == pytest.approx(cep, rel=0.08)


def test_refusals_have_their_reason_and_no_numbers():
    given = [[960, 540], [960, 100], [-50, 500], [np.nan, 3]]
    got = locate(_pose(30.0, 80.0, 0.0), PINHOLE, given, NOISE)
    assert got.reasons == (
        None, Reason.ABOVE_HORIZON, Reason.OUTSIDE_CALIBRATED_IMAGE, Reason.BAD_DETECTIONS,
    )  # fmt: skip
    assert got.valid.tolist() == [True, False, False, False]
    assert np.isfinite(got.latitude).tolist() == [True, False, False, False]
    assert np.isfinite(got.covariance).all(axis=(1, 2)).tolist() == [True, False, False, False]


@pytest.mark.parametrize(
    ("changes", "off_nadir", "reason"),
    [
        ({}, 84.0, None),  # 287 m
        ({"surface.max_range": 200.0}, 84.0, Reason.OUT_OF_RANGE),
        ({"surface.max_sigma_m": 5.0}, 84.0, Reason.OUT_OF_RANGE),
        ({}, 89.5, Reason.ABOVE_HORIZON),  # meets the water, but 3 sigma of tilt does not
        ({}, 95.0, Reason.ABOVE_HORIZON),
    ],
)
def test_near_the_horizon_nothing_is_reported(changes, off_nadir, reason):
    pose = _pose(30.0, off_nadir, 70.0)
    got = locate(pose, PINHOLE, [[960, 540]], NOISE, estimator_config(changes))
    assert got.reasons == (reason,)


def test_three_sigma_of_tilt_decide_what_is_near_the_horizon():
    # 3 sigma: 3 hypot(0.4, 0.03, 2 px) = 1.24 deg, and the horizon dips by 0.18 deg
    config = EstimatorConfig()
    reasons = [
        locate(_pose(30.0, 90.0 - down, 70.0), PINHOLE, [[960, 540]], NOISE, config).reasons[0]
        for down in (1.39, 1.45)
    ]
    assert reasons[0] is Reason.ABOVE_HORIZON
    assert reasons[1] is not Reason.ABOVE_HORIZON


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"height": 0.0}, Reason.BAD_HEIGHT),
        ({"height": -4.2}, Reason.BAD_HEIGHT),
        ({"height": math.nan}, Reason.BAD_HEIGHT),
        ({"latitude": math.nan}, Reason.BAD_FIX),
        ({"enu_from_camera": np.full((3, 3), np.nan)}, Reason.BAD_GIMBAL),
    ],
)
def test_a_pose_that_cannot_be_is_refused(change, reason):
    got = locate(replace(_pose(30.0, 45.0, 0.0), **change), PINHOLE, [[1, 2], [3, 4]], NOISE)
    assert got.reasons == (reason, reason)
    assert np.isnan(got.east_north).all()


def test_no_detections_give_no_points():
    got = locate(_pose(30.0, 45.0, 0.0), PINHOLE, np.zeros((0, 2)), NOISE)
    assert len(got) == 0
    assert got.covariance.shape == (0, 2, 2)


def test_attitude_noise_enters_only_where_the_attitude_is_used():
    pose = _pose(30.0, 45.0, 0.0)
    traces = {
        reference: np.sum(uncertainty(pose, NOISE, reference).rotation_white ** 2)
        for reference in ("earth", "heading", "body", "fixed")
    }
    gimbal, attitude = math.radians(0.03) ** 2, math.radians(0.1) ** 2
    assert traces == pytest.approx(
        {
            "earth": 3 * gimbal,
            "heading": 3 * gimbal + attitude,
            "body": 3 * (gimbal + attitude),
            "fixed": 3 * attitude,
        }
    )
