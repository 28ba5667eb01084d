# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""OpenCV's operations on planes, each on numbers that a hand can check."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.simulation.planes import merge, remap, resize, shrink, split, transform

RAMP = np.arange(12, dtype=np.float32).reshape(3, 4)


def test_between_pixels_values_are_linear_and_beyond_the_edge_goes_on():
    x = np.array([[0.5, 1.25, -3.0, 9.0]], np.float32)
    y = np.array([[0.0, 1.0, 0.0, 2.0]], np.float32)
    assert remap(RAMP, x, y)[0] == pytest.approx([0.5, 5.25, 0.0, 11.0])


def test_an_image_is_its_planes():
    image = np.stack([RAMP, 2.0 * RAMP, 3.0 * RAMP], axis=2).astype(np.float32)
    assert [float(plane[0, 1]) for plane in split(image)] == [1.0, 2.0, 3.0]
    assert (merge(split(image)) == image).all()


def test_a_matrix_is_applied_to_each_pixel():
    image = np.ones((2, 2, 3), np.float32) * [1.0, 2.0, 3.0]
    matrix = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    assert transform(image.astype(np.float32), matrix)[1, 1].tolist() == [2.0, 1.0, 6.0]


def test_a_smaller_image_is_made_of_means_and_a_larger_one_keeps_them():
    assert shrink(RAMP[:2], (2, 1)).tolist() == [[2.5, 4.5]]
    assert resize(RAMP, (8, 6)).mean() == pytest.approx(RAMP.mean())
    assert resize(RAMP, (8, 6)).shape == (6, 8)
