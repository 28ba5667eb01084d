# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Points before a lens on its image plane: OpenCV's places, and derivatives by differences."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.camera.distortion import BrownConrady, Equidistant
from aerial_gnss_ros.core.camera.projection import plane_with_jacobian

RATIONAL = [-0.2, 0.05, 1e-3, -5e-4, 0.02, 0.1, 0.03, 0.01]
FISHEYE = [0.02, -0.01, 0.003, -0.001]
LENSES = {
    "pinhole": (None, lambda points: _opencv(points, np.zeros(5))),
    "rational": (BrownConrady(np.array(RATIONAL)), lambda points: _opencv(points, RATIONAL)),
    "fisheye": (Equidistant(np.array(FISHEYE)), lambda points: _opencv(points, FISHEYE, True)),
}
RNG = np.random.default_rng(3)
POINTS = RNG.uniform([-6.0, -6.0, 8.0], [6.0, 6.0, 40.0], (40, 3))


def _opencv(points, d, fisheye=False):
    project = cv2.fisheye.projectPoints if fisheye else cv2.projectPoints
    zero = np.zeros(3)
    return project(points[:, None, :].copy(), zero, zero, np.eye(3), np.array(d))[0][:, 0]


@pytest.mark.parametrize("name", LENSES)
def test_places_on_the_plane_are_those_of_opencv(name):
    lens, truth = LENSES[name]
    plane, _, seen = plane_with_jacobian(lens, POINTS)
    assert seen.all()
    np.testing.assert_allclose(plane, truth(POINTS), atol=1e-9)


@pytest.mark.parametrize("name", LENSES)
def test_derivatives_are_differences(name):
    lens, _ = LENSES[name]
    _, by_point, _ = plane_with_jacobian(lens, POINTS)
    for axis in range(3):
        step = 1e-5 * np.eye(3)[axis]
        ends = [plane_with_jacobian(lens, POINTS + sign * step)[0] for sign in (1, -1)]
        np.testing.assert_allclose(by_point[:, :, axis], (ends[0] - ends[1]) / 2e-5, atol=1e-8)


@pytest.mark.parametrize("name", LENSES)
def test_on_the_axis_the_scale_is_the_inverse_distance(name):
    lens, _ = LENSES[name]
    plane, by_point, seen = plane_with_jacobian(lens, np.array([[0.0, 0.0, 20.0]]))
    assert seen.all()
    np.testing.assert_allclose(plane, 0.0, atol=1e-12)
    np.testing.assert_allclose(by_point[0], [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0]], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "point", "seen"),
    [
        ("pinhole", (1.0, 0.0, 1.0), True),
        ("pinhole", (1.0, 0.0, 0.0), False),
        ("pinhole", (0.0, 0.0, -5.0), False),
        ("rational", (0.0, 1.0, -5.0), False),
        ("rational", (1e6, 0.0, 1.0), False),
        ("fisheye", (1.0, 0.0, 0.0), True),  # sideways
        ("fisheye", (0.0, 0.0, 0.0), False),
    ],
)
def test_what_is_behind_or_beyond_the_fold_is_not_seen(name, point, seen):
    lens, _ = LENSES[name]
    others = np.array([[0.1, 0.2, 3.0], point, [0.0, 0.1, 2.0]])
    with np.errstate(all="raise"):
        plane, by_point, found = plane_with_jacobian(lens, others)
    assert found.tolist() == [True, seen, True]
    alone = plane_with_jacobian(lens, others[::2])
    np.testing.assert_array_equal(plane[::2], alone[0])
    np.testing.assert_array_equal(by_point[::2], alone[1])


def test_a_fisheye_ends_where_its_angle_does():
    lens = Equidistant(np.array([-0.1, 0.0, 0.0, 0.0]))  # folds at 1 = 0.3 angle²
    fold = math.sqrt(1.0 / 0.3)
    points = [[math.sin(a), 0.0, math.cos(a)] for a in (fold - 0.01, fold + 0.01)]
    assert plane_with_jacobian(lens, np.array(points))[2].tolist() == [True, False]
