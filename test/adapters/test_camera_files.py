# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera's description as a file: both forms, what is written, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters.camera_files import camera_file_text, read_camera_file
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import CameraError, InputError

D, K = [-0.361, 0.118, 0.0012, -0.0004, 0.0], [438.7, 0.0, 305.6, 0.0, 437.3, 243.7, 0.0, 0.0, 1.0]
CALIBRATION = (
    "image_width: 640\nimage_height: 480\ncamera_name: left\ndistortion_model: plumb_bob\n"
    f"camera_matrix: {{rows: 3, cols: 3, data: {K}}}\n"
    f"distortion_coefficients: {{rows: 1, cols: 5, data: {D}}}\n"
)
ECHO = f"height: 480\nwidth: 640\ndistortion_model: plumb_bob\nd: {D}\nk: {K}\n---\n"
ROS_1 = f"height: 480\nwidth: 640\ndistortion_model: plumb_bob\nD: {D}\nK: {K}\n---\n"


def read(tmp_path, text):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    return read_camera_file(path)


@pytest.mark.parametrize(
    ("text", "name"),
    [(CALIBRATION, "left"), (ECHO, ""), (ROS_1, "")],
    ids=["file", "echo", "ROS 1"],
)
def test_every_form_of_a_camera_info_is_read(tmp_path, text, name):
    found = read(tmp_path, text)
    assert (found.name, found.camera.width, found.camera.height) == (name, 640, 480)
    assert found.camera.K.ravel().tolist() == K
    assert found.camera.D.tolist() == D


@pytest.mark.parametrize(
    ("model", "coefficients"),
    [("equidistant", [0.1, -0.01, 0.002, -0.0003]), ("plumb_bob", D), ("plumb_bob", [])],
)
def test_what_is_written_is_read_back(tmp_path, model, coefficients):
    matrix = np.array([[300.25, 0, 399.5], [0, 301.0, 299.5], [0, 0, 1]])
    camera = CameraModel(800, 600, model, matrix, np.array(coefficients))
    found = read(tmp_path, camera_file_text(camera, "fisheye"))
    assert (found.name, found.camera.model) == ("fisheye", model)
    assert (found.camera.width, found.camera.height) == (800, 600)
    np.testing.assert_allclose(found.camera.K, matrix)
    np.testing.assert_allclose(found.camera.D[: len(coefficients)], coefficients)


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        (
            "a: 1\n",
            InputError,
            "has no image_width, image_height, camera_matrix",
        ),
        ("just text\n", InputError, "holds no CameraInfo"),
        ("[1, : ]\n", InputError, "is not YAML"),
        (CALIBRATION.replace("438.7", "zoom"), InputError, "not a number"),
        (CALIBRATION.replace("640", "640.5"), InputError, "640.5 is not a whole number"),
        (ECHO.replace(str(K), "500"), InputError, "500 is not a list of numbers"),
        (CALIBRATION.replace("438.7", "0.0"), CameraError, "impossible K"),
        (CALIBRATION.replace("plumb_bob", "fancy"), CameraError, "distortion model 'fancy'"),
    ],
)
def test_files_that_are_no_camera_are_refused_by_name(tmp_path, text, error, words):
    with pytest.raises(error, match=words) as refused:
        read(tmp_path, text)
    assert "camera.yaml" in str(refused.value)
