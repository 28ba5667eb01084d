# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera models against OpenCV, and every refusal."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import CameraError

K = np.array([[1000.0, 0.0, 640.5], [0.0, 1005.0, 355.0], [0.0, 0.0, 1.0]])
LENSES = {
    "none": ("plumb_bob", []),
    "unnamed": ("", [0.0] * 5),
    "two": ("plumb_bob", [-0.1, 0.02]),
    "barrel": ("plumb_bob", [-0.3, 0.1, 1e-3, -5e-4, 0.02]),
    "pincushion": ("plumb_bob", [0.2, 0.05, -1e-3, 5e-4, 0.0]),
    "rational": ("rational_polynomial", [0.5, 0.1, 1e-3, -5e-4, 0.02, 0.6, 0.2, 0.01]),
    "fisheye": ("equidistant", [0.02, -0.01, 0.003, -0.001]),
    "ideal fisheye": ("equidistant", [0.0] * 4),
}


def _camera(name, width=1280, height=720):
    model, d = LENSES[name]
    return CameraModel.from_camera_info(width, height, model, d, K.ravel())


def _opencv(name, points):
    model, d = LENSES[name]
    project = cv2.fisheye.projectPoints if model == "equidistant" else cv2.projectPoints
    d = np.array([*d, *[0.0] * max(0, 4 - len(d))])
    zero = np.zeros(3)
    return project(np.ascontiguousarray(points)[:, None, :], zero, zero, K, d)[0][:, 0]


def _grid(camera):
    u, v = np.meshgrid(np.linspace(0, camera.width - 1, 23), np.linspace(0, camera.height - 1, 17))
    return np.column_stack([u.ravel(), v.ravel()])


@pytest.mark.parametrize("name", LENSES)
def test_every_pixel_comes_back_through_opencv(name):
    camera = _camera(name)
    pixels = _grid(camera)
    rays, valid = camera.rays(pixels)
    assert valid.all()
    assert np.linalg.norm(rays, axis=1) == pytest.approx(1.0)
    assert _opencv(name, rays * 30.0) == pytest.approx(pixels, abs=1e-6)
    ours, seen = camera.project(rays * 30.0)
    assert seen.all()
    assert ours == pytest.approx(pixels, abs=1e-6)


@pytest.mark.parametrize("name", LENSES)
def test_the_rays_derivative_is_that_of_finite_differences(name):
    camera = _camera(name)
    pixels = _grid(camera)[30:-30]
    step = 1e-3
    differences = np.stack(
        [
            (camera.rays(pixels + e)[0] - camera.rays(pixels - e)[0]) / (2.0 * step)
            for e in np.eye(2) * step
        ],
        axis=-1,
    )
    assert camera.rays_with_jacobian(pixels)[1] == pytest.approx(differences, abs=1e-9)


@given(st.floats(-0.35, 0.25), st.floats(-0.1, 0.1), st.floats(-2e-3, 2e-3), st.floats(-2e-3, 2e-3))
def test_a_valid_ray_always_projects_to_its_pixel(k1, k2, p1, p2):
    camera = CameraModel.from_camera_info(1280, 720, "plumb_bob", [k1, k2, p1, p2, 0.0], K)
    pixels = _grid(camera)
    rays, valid = camera.rays(pixels)
    back, _ = camera.project(rays[valid])
    assert back == pytest.approx(pixels[valid], abs=1e-4)


def test_pixels_beyond_the_lens_models_fold_are_not_valid():
    # r (1 - r²/2) grows up to r = 0.8165, where it is 0.5443: 544 px from the middle.
    camera = CameraModel.from_camera_info(
        1280,
        1280,
        "plumb_bob",
        [-0.5, 0, 0, 0],
        [
            1000,
            0,
            640,
            0,
            1000,
            640,
            0,
            0,
            1,
        ],
    )
    radius = np.array([0.0, 300.0, 540.0, 544.0, 545.0, 600.0])
    rays, valid = camera.rays(np.column_stack([640.0 + radius, np.full(6, 640.0)]))
    assert valid.tolist() == [True, True, True, True, False, False]
    assert rays[3, 0] / rays[3, 2] < 0.8165
    # A point out there would be seen at a pixel inside: that pixel is another point's.
    assert camera.project([[0.5, 0.0, 1.0], [1.1, 0.0, 1.0]])[1].tolist() == [True, False]


def test_a_fisheye_sees_sideways_but_not_beyond_its_fold():
    k = [200, 0, 640, 0, 200, 640, 0, 0, 1]
    camera = CameraModel.from_camera_info(1281, 1281, "equidistant", [0.0] * 4, k)
    rays, valid = camera.rays([[640 + 200 * math.pi / 2, 640], [640 + 200 * 2.0, 640]])
    assert valid.all()
    assert rays[0] == pytest.approx([1, 0, 0], abs=1e-12)
    assert rays[1] == pytest.approx([math.sin(2.0), 0, math.cos(2.0)], abs=1e-12)
    assert camera.project(rays)[0][1] == pytest.approx([1040, 640])
    # t (1 - t²/3) grows up to t = 1, where it is 2/3: 400 px.
    k = [600, 0, 640, 0, 600, 640, 0, 0, 1]
    folded = CameraModel.from_camera_info(1281, 1281, "equidistant", [-1 / 3, 0, 0, 0], k)
    assert folded.rays([[1030, 640], [1050, 640]])[1].tolist() == [True, False]


def test_points_behind_and_pixels_off_the_image_are_not_valid():
    camera = _camera("barrel")
    pixels, seen = camera.project([[0, 0, 5], [0, 0, -5], [0, 0, 0], [4, 0, 5]])
    assert seen.tolist() == [True, False, False, False]
    assert np.isnan(pixels[1]).all()
    assert pixels[3, 0] > camera.width
    _, valid = camera.rays([[0, 0], [-2, 0], [0, 721], [np.nan, 3], [1e300, 3], [np.inf, 0]])
    assert valid.tolist() == [True, False, False, False, False, False]


def test_rectified_images_use_p_and_undo_the_rectification():
    turn = cv2.Rodrigues(np.array([0.02, -0.03, 0.01]))[0]
    p = [900.0, 0, 600, -90.0, 0, 900.0, 350, 0, 0, 0, 1, 0]
    camera = CameraModel.from_camera_info(
        1280, 720, "plumb_bob", [-0.3, 0.1, 0, 0, 0], K, turn, p, True
    )
    assert not camera.D.any()
    rays, valid = camera.rays([[600, 350], [100, 100]])
    assert valid.all()
    assert rays[0] == pytest.approx(turn.T @ [0, 0, 1])
    back, _ = camera.project(rays)
    assert back == pytest.approx(np.array([[600, 350], [100, 100]]))
    slope = (camera.rays([[100.001, 100]])[0] - camera.rays([[99.999, 100]])[0]) / 2e-3
    assert camera.rays_with_jacobian([[100, 100]])[1][0, :, 0] == pytest.approx(slope[0], abs=1e-9)


def test_focal_length_and_sensor_size_give_the_field_of_view():
    camera = CameraModel.from_focal_length(0.0203, 0.036, None, 1920, 1080)
    assert camera.K[0, 0] == pytest.approx(1082.667, abs=1e-3)
    assert camera.K[1, 1] == camera.K[0, 0]
    edge = camera.rays([[0, 540]])[0][0]
    assert math.atan2(-edge[0], edge[2]) == pytest.approx(math.atan(0.036 / (2 * 0.0203)))
    tall = CameraModel.from_focal_length(0.0203, 0.036, 0.024, 1920, 1080)
    assert tall.K[1, 1] == pytest.approx(0.0203 * 1080 / 0.024)


GOOD = {
    "width": 1280, "height": 720, "distortion_model": "plumb_bob", "d": [0.0] * 5, "k": K,
    "r": np.eye(3), "p": np.hstack([K, np.zeros((3, 1))]), "rectified": False,
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"k": np.zeros(9)}, "zeros"),
        ({"k": np.full(9, np.nan)}, "nan"),
        ({"k": [1000, 0, 640, 0, -5, 360, 0, 0, 1]}, "-5"),
        ({"k": [1000, 0, 640]}, "3 numbers"),
        ({"width": 0}, "0 x 720"),
        ({"height": 0}, "1280 x 0"),
        ({"distortion_model": "fisheye62"}, "'fisheye62'"),
        ({"distortion_model": "", "d": [0.1, 0, 0, 0, 0]}, "no distortion_model"),
        ({"d": [0.1] * 8}, "8 distortion coefficients"),
        ({"d": [0.1, np.nan, 0, 0, 0]}, "nan"),
        ({"d": [0.1, 0, 0, 0, 1e308]}, "above 1e"),
        ({"distortion_model": "rational_polynomial", "d": [0.1, -1.1e6, *[0] * 6]}, "above 1e"),
        ({"distortion_model": "rational_polynomial", "d": [0.1] * 5}, "has 8"),
        ({"distortion_model": "equidistant", "d": [0.1] * 5}, "has 4"),
        ({"rectified": True, "p": np.zeros(12)}, "P of zeros"),
        ({"rectified": True, "r": np.zeros(9)}, "not a rotation"),
        ({"rectified": True, "p": None}, "no P"),
        ({"binning": (2, 2)}, "binning 2 x 2"),
        ({"roi": (10, 20, 640, 480)}, "region of interest"),
    ],
)
def test_a_camera_that_cannot_be_used_is_refused_with_the_value_seen(change, words):
    CameraModel.from_camera_info(**GOOD)
    with pytest.raises(CameraError, match=words):
        CameraModel.from_camera_info(**{**GOOD, **change})


@pytest.mark.parametrize(
    ("model", "d", "folds"),
    [
        ("plumb_bob", [-0.3, 0.1, 0.001, 0.001, -0.02], False),  # an action camera
        ("plumb_bob", [-1.0], False),  # folds over at 0.58, where the corners are
        ("plumb_bob", [-4.0], True),
        ("plumb_bob", [-0.045, 0.018, 33.2, -0.0003, -0.004], True),  # a wild number in one of five
        ("plumb_bob", [0.0, 0.0, 0.0, -33.2], True),
        ("rational_polynomial", [-5.0, 0, 0, 0, 0, 0.0, 0, 0], True),
        ("equidistant", [-0.05, 0.01, -0.005, 0.001], False),
        ("equidistant", [-10.0, 0.0, 0.0, 0.0], True),
    ],
)
def test_a_lens_that_folds_over_in_the_middle_of_the_image_is_none(model, d, folds):
    given = (1280, 720, model, d, [854.0, 0, 640, 0, 854.0, 360, 0, 0, 1])
    if not folds:
        assert CameraModel.from_camera_info(*given).rays([[640.0, 360.0]])[1].all()
        return
    with pytest.raises(CameraError, match="folds over"):
        CameraModel.from_camera_info(*given)


@pytest.mark.parametrize(("model", "count"), [("plumb_bob", 5), ("rational_polynomial", 8)])
def test_the_largest_coefficients_that_are_not_refused_give_finite_rays(model, count):
    rng, used = np.random.default_rng(1), 0
    pixels = rng.uniform((0.0, 0.0), (1280.0, 720.0), (20, 2))
    for _ in range(50):
        d = rng.choice([-1e6, -1.0, -1e-16, 0.0, 1e-15, 1e6], count)
        try:
            camera = CameraModel.from_camera_info(**{**GOOD, "distortion_model": model, "d": d})
        except CameraError as error:
            assert "folds over" in str(error)  # noqa: PT017 - others are not looked at
            continue
        rays, valid = camera.rays(pixels)
        assert np.isfinite(rays[valid]).all()
        used += 1
    assert used > 3


@pytest.mark.parametrize("values", [(0.0, 0.036, None), (0.02, -1.0, None), (0.02, 0.03, 0.0)])
def test_lengths_that_are_not_positive_are_refused(values):
    with pytest.raises(CameraError, match="must be a positive length"):
        CameraModel.from_focal_length(*values, 1920, 1080)


def test_binning_of_one_and_a_whole_region_are_no_binning_and_no_region():
    CameraModel.from_camera_info(**GOOD, binning=(1, 1), roi=(0, 0, 1280, 720))


def test_a_model_keeps_its_own_numbers():
    k = K.copy()
    camera = CameraModel.from_camera_info(1280, 720, "plumb_bob", [], k)
    k[0, 0] = 5.0
    assert camera.K[0, 0] == 1000.0
    with pytest.raises(ValueError, match="read-only"):
        camera.K[0, 0] = 5.0


def test_no_pixels_give_no_rays():
    rays, valid = _camera("barrel").rays(np.zeros((0, 2)))
    assert rays.shape == (0, 3)
    assert valid.shape == (0,)
