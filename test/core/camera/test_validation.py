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
