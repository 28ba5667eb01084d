# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rays through places on the image plane: the way back of `projection`, with its derivative."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.distortion import BrownConrady, Equidistant
from aerial_gnss_ros.core.camera.projection import plane_with_jacobian
from aerial_gnss_ros.core.camera.rays import fisheye_rays, pinhole_rays

BROWN = BrownConrady(np.array([-0.2, 0.05, 1e-3, -5e-4, 0.02, 0.1, 0.03, 0.01]))
FISHEYE = Equidistant(np.array([0.02, -0.01, 0.003, -0.001]))
LENSES = {
    "pinhole": (None, lambda plane: pinhole_rays(None, plane)),
    "rational": (BROWN, lambda plane: pinhole_rays(BROWN, plane)),
    "fisheye": (FISHEYE, lambda plane: fisheye_rays(FISHEYE, plane)),
}
PLANE = np.random.default_rng(5).uniform(-0.7, 0.7, (40, 2))


@pytest.mark.parametrize("name", LENSES)
def test_rays_have_length_one_and_lead_back_to_their_places(name):
    lens, rays_of = LENSES[name]
    rays, _, valid = rays_of(PLANE)
    assert valid.all()
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, rtol=1e-12)
    back, _, seen = plane_with_jacobian(lens, 7.0 * rays)
    assert seen.all()
    np.testing.assert_allclose(back, PLANE, atol=1e-9)


@pytest.mark.parametrize("name", LENSES)
def test_derivatives_are_differences(name):
    _, rays_of = LENSES[name]
    _, by_place, _ = rays_of(PLANE)
    for axis in range(2):
        step = 1e-5 * np.eye(2)[axis]
        difference = (rays_of(PLANE + step)[0] - rays_of(PLANE - step)[0]) / 2e-5
        np.testing.assert_allclose(by_place[:, :, axis], difference, atol=1e-7)


def test_places_of_a_pocket_calculator():
    rays, by_place, _ = pinhole_rays(None, np.array([[0.0, 0.0], [0.75, 0.0]]))
    np.testing.assert_allclose(rays, [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
    np.testing.assert_allclose(by_place[0], [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    # x / sqrt(1 + x²) has the slope (1 + x²)^-1.5 = 0.8³
    np.testing.assert_allclose(by_place[1], [[0.512, 0.0], [0.0, 0.8], [-0.384, 0.0]])


def test_an_ideal_fisheye_has_the_angle_as_its_radius():
    ideal = Equidistant(np.zeros(4))
    rays, by_place, valid = fisheye_rays(ideal, np.array([[0.0, math.pi / 3], [0.0, 0.0]]))
    assert valid.all()
    np.testing.assert_allclose(rays, [[0.0, math.sqrt(0.75), 0.5], [0.0, 0.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(by_place[1], [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]], atol=1e-12)
    # Sideways the circle of latitude sin(60 deg) turns by 1 / radius.
    across = math.sqrt(0.75) / (math.pi / 3)
    np.testing.assert_allclose(
        by_place[0], [[across, 0.0], [0.0, 0.5], [0.0, -math.sqrt(0.75)]], atol=1e-9
    )
