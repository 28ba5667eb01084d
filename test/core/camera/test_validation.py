# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every refusal of a CameraInfo, and what is just good enough for none."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.camera import validation
from aerial_gnss_ros.core.values.errors import CameraError

K = np.array([[500.0, 0.0, 320.0], [0.0, 510.0, 240.0], [0.0, 0.0, 1.0]])
WHOLE = (0, 0, 640, 480)


def _with(row, column, value):
    matrix = K.copy()
    matrix[row, column] = value
    return matrix


def _matrix(fx, fy):
    return np.array([[fx, 0.0, 320.0], [0.0, fy, 240.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("size", [(0, 480), (640, 0), (-1, 480), (640, -480)])
def test_an_image_without_pixels_is_refused(size):
    validation.check_size(1, 1)
    with pytest.raises(CameraError, match=f"an image of {size[0]} x {size[1]} px"):
        validation.check_size(*size)


@pytest.mark.parametrize(
    ("binning", "roi", "words"),
    [
        ((2, 1), WHOLE, "binning 2 x 1"),
        ((1, 2), WHOLE, "binning 1 x 2"),
        ((1, 1), (0, 0, 640, 479), "640 x 479 px at 0, 0"),
        ((1, 1), (1, 0, 640, 480), "640 x 480 px at 1, 0"),
    ],
)
def test_a_part_of_the_image_is_refused(binning, roi, words):
    for one in ((0, 0), (1, 1), (0, 1)):
        validation.check_whole_image(640, 480, one, (0, 0, 0, 0))
        validation.check_whole_image(640, 480, one, WHOLE)
    with pytest.raises(CameraError, match=words):
        validation.check_whole_image(640, 480, binning, roi)


def test_a_matrix_of_a_message_has_nine_numbers():
    np.testing.assert_array_equal(validation.as_matrix(range(9), "K")[1], [3.0, 4.0, 5.0])
    with pytest.raises(CameraError, match="R with 8 numbers instead of 9"):
        validation.as_matrix(range(8), "R")


def test_no_model_is_a_pinhole_unless_there_are_coefficients():
    assert validation.model_name("", []) == validation.model_name("", [0.0] * 5) == "plumb_bob"
    assert validation.model_name("equidistant", [0.1]) == "equidistant"
    with pytest.raises(CameraError, match="but no distortion_model"):
        validation.model_name("", [0.0, -0.1])


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.zeros((3, 3)), "of zeros: the camera is not calibrated"),
        (K[:2], "must be 3 x 3"),
        (_with(0, 0, 0.0), "impossible K"),
        (_with(0, 0, -500.0), "impossible K"),
        (_with(1, 1, 0.0), "impossible K"),
        (_with(1, 0, 1e-6), "impossible K"),
        (_with(0, 2, np.nan), "impossible K"),
        (_with(2, 2, 2.0), "impossible K"),
        (_with(2, 0, 1.0), "impossible K"),
    ],
)
def test_a_camera_matrix_that_cannot_be_is_refused(matrix, words):
    skewed = _with(0, 1, 3.0)  # that can be
    np.testing.assert_array_equal(validation.checked_matrix(skewed, "K"), skewed)
    with pytest.raises(CameraError, match=words):
        validation.checked_matrix(matrix, "K")


@pytest.mark.parametrize(
    ("fx", "fy", "model", "words"),
    [
        # 2 atan(320 / 27.5) = 170.18 deg, 2 atan(240 / 20.6) = 170.19 deg, 240 / 38.1 = 360.9 deg
        (27.5, 510.0, "plumb_bob", "640 x 480 px and fx is 27.5 px, so it would show 170.2 deg"),
        (500.0, 20.6, "rational_polynomial", "fy is 20.6 px, so it would show 170.2 deg"),
        (5.0, 5.1, "plumb_bob", "fx is 5 px, so it would show 178.2 deg"),
        (38.1, 38.1, "equidistant", "fx is 38.1 px, so the middle half would show 360.9 deg"),
        (500.0, 5.1, "equidistant", "fy is 5.1 px, so the middle half would show 2696.3 deg"),
    ],
)
def test_a_view_wider_than_any_lens_of_the_model_is_refused(fx, fy, model, words):
    for wide in ((28.1, 21.1, "plumb_bob"), (38.3, 38.3, "equidistant")):
        validation.check_view(_matrix(wide[0], wide[1]), 640, 480, wide[2])
    with pytest.raises(CameraError, match=words):
        validation.check_view(_matrix(fx, fy), 640, 480, model)


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        (0, 0.0, "cx is 0 px, and the image has 640 x 480 px"),
        (0, 640.0, "cx is 640 px"),
        (0, -1.0, "cx is -1 px"),
        (1, 480.0, "cy is 480 px"),
        (1, 0.0, "cy is 0 px"),
    ],
)
def test_a_principal_point_is_in_its_image(column, value, words):
    for region in (1.0, 479.0):  # of a camera's image; it may have the point near an edge
        validation.check_view(_with(column, 2, region), 640, 480, "plumb_bob")
    with pytest.raises(CameraError, match=words):
        validation.check_view(_with(column, 2, value), 640, 480, "plumb_bob")


@pytest.mark.parametrize("matrix", [1.001 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.zeros((3, 3))])
def test_a_rectification_is_a_rotation(matrix):
    for one in (np.eye(3), np.diag([1.0, -1.0, -1.0]), np.eye(3) + 1e-6):
        assert validation.checked_rotation(one) is one
    with pytest.raises(CameraError, match="not a rotation"):
        validation.checked_rotation(matrix)


@pytest.mark.parametrize(
    ("model", "counts"),
    [("plumb_bob", range(6)), ("rational_polynomial", (0, 8)), ("equidistant", (4,))],
)
def test_the_number_of_coefficients_fits_the_model(model, counts):
    for count in range(10):
        d = [0.1] * count
        if count in counts:
            assert validation.checked_coefficients(model, d).tolist() == d
        else:
            with pytest.raises(CameraError, match=f"has {count} distortion coefficients; {model}"):
                validation.checked_coefficients(model, d)


@pytest.mark.parametrize(
    ("model", "d", "words"),
    [
        ("thin_prism", [0.1], "'thin_prism', which is not known"),
        ("plumb_bob", [0.1, np.inf], "not all finite"),
        ("plumb_bob", [-1.01e6], "no lens has coefficients above 1e"),
    ],
)
def test_coefficients_of_no_lens_are_refused(model, d, words):
    validation.checked_coefficients("plumb_bob", [-1e6])
    with pytest.raises(CameraError, match=words):
        validation.checked_coefficients(model, d)
