# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's motion in the picture, by points whose places are known."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.image_motion import (
    CHANGE,
    TUNING,
    Motion,
    by_motion,
    fitted,
    in_picture,
    moved,
    on_plane,
)
from aerial_gnss_ros.core.camera.model import CameraModel

CAMERA = CameraModel.from_camera_info(
    640, 480, "plumb_bob", [], [500.0, 0, 320.0, 0, 400.0, 240.0, 0, 0, 1.0]
)
POINTS = np.array([[0.0, 0.0], [0.3, 0.1], [-0.2, 0.25], [0.1, -0.3]])


def _motion(*mean, variance=1.0):
    return Motion(np.array(mean, np.float64), variance * np.eye(6))


@pytest.mark.parametrize(
    ("motion", "after"),
    [
        ((0.1, -0.2, 0, 0, 0, 0), [0.4, -0.1]),
        ((0, 0, 0.5, 0, 0, 0), [0.45, 0.1]),
        ((0, 0, 0, 0.5, 0, 0), [0.35, 0.1]),
        ((0, 0, 0, 0, 0.5, 0), [0.3, 0.25]),
        ((0, 0, 0, 0, 0, 0.5), [0.3, 0.15]),
    ],
)
def test_each_part_of_a_motion_moves_points_its_way(motion, after):
    np.testing.assert_allclose(moved(POINTS[1:2], _motion(*motion))[0], after)


def test_points_tell_a_motion_of_which_nothing_is_known():
    true = _motion(0.02, -0.03, 0.1, -0.2, 0.15, -0.05)
    found = fitted(POINTS, moved(POINTS, true), np.full(4, 1e-8), _motion(*[0.0] * 6))
    np.testing.assert_allclose(found.mean, true.mean, atol=1e-6)


def test_points_are_weighed_against_what_is_expected():
    """The least-squares normal equations, as a textbook has them."""
    rng = np.random.default_rng(1)
    expected = Motion(0.1 * rng.normal(size=6), np.diag(rng.uniform(0.5, 2.0, 6)))
    after, variances = POINTS + 0.1 * rng.normal(size=(4, 2)), rng.uniform(0.1, 1.0, 4)
    A = by_motion(POINTS).reshape(8, 6)
    weight = np.diag(1.0 / np.repeat(variances, 2))
    known = np.linalg.inv(expected.covariance)
    covariance = np.linalg.inv(known + A.T @ weight @ A)
    right = known @ expected.mean + A.T @ weight @ (after - POINTS).ravel()
    found = fitted(POINTS, after, variances, expected)
    np.testing.assert_allclose(found.mean, covariance @ right)
    np.testing.assert_allclose(found.covariance, covariance)


def test_without_points_the_motion_stays_as_expected():
    none, expected = np.zeros((0, 2)), _motion(0.1, 0.2, 0, 0, 0, 0, variance=3.0)
    found = fitted(none, none, np.zeros(0), expected)
    np.testing.assert_allclose(found.mean, expected.mean)
    np.testing.assert_allclose(found.covariance, expected.covariance)


@pytest.mark.parametrize(
    ("rate", "share"),
    [
        ((1, 0, 0, 0, 0, 0), 1.0),  # a turn of the camera
        ((0, 0, 0, -1, 1, 0), 1.0),  # a turn about its axis
        ((0, 0, 1, 0, 0, 1), 1.0),  # a change of the distance
        ((0, 0, 0, 1, 1, 0), TUNING.shear_share),  # shears
        ((0, 0, 1, 0, 0, -1), TUNING.shear_share),
    ],
)
def test_rates_change_as_cameras_do(rate, share):
    one = np.array(rate, np.float64)
    one /= np.linalg.norm(one)
    assert one @ CHANGE @ one == pytest.approx((share * TUNING.rate_change_sigma) ** 2)
    np.testing.assert_allclose(CHANGE @ one, (one @ CHANGE @ one) * one, atol=1e-12)


def test_pixels_come_to_lie_on_the_plane_and_are_cut_off_far_outside():
    far = TUNING.cut_off_coordinates
    pixels = [[320.0, 240.0], [570.0, 40.0], [320.0 + 600 * far, 240.0 - 600 * far]]
    np.testing.assert_allclose(
        on_plane(np.array(pixels), CAMERA), [[0.0, 0.0], [0.5, -0.5], [far, -far]]
    )


@pytest.mark.parametrize(
    ("u", "v", "inside"),
    [(0.0, 0.0, True), (639.9, 479.9, True), (-0.1, 9.0, False), (9.0, -0.1, False),
     (640.0, 9.0, False), (9.0, 480.0, False)],
)  # fmt: skip
def test_the_picture_ends_with_its_last_pixel(u, v, inside):
    assert in_picture((u - 320.0) / 500.0, (v - 240.0) / 400.0, CAMERA) is inside
