# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where robots are seen, by an independent library, and derivatives by differences."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.models.platform_model import COUNT

sys.path.insert(0, str(Path(__file__).parent))

from three_robots import CAMERA, PLACES, sight

ERRORS = np.array([0.5, -0.3, 0.2, 0.004, -0.006, 0.02, 0.01, -0.02, 0.0])


def test_pixels_are_those_of_opencv():
    pose = sight().pose(ERRORS)
    to_optical = (pose.rotation @ FLU_FROM_OPTICAL).T
    points = np.column_stack([PLACES, np.zeros(3)])
    rotation, _ = cv2.Rodrigues(to_optical)
    expected, _ = cv2.projectPoints(points, rotation, -to_optical @ pose.position, CAMERA.K, None)
    found = linearise(sight(), ERRORS, PLACES).pixels
    np.testing.assert_allclose(found, expected[:, 0], atol=2e-3)  # the water is curved


def test_derivatives_are_differences_over_small_steps():
    found = linearise(sight(), np.zeros(COUNT), PLACES)
    for axis in range(2):
        step = 1e-4 * np.eye(2)[axis]
        after, before = (
            linearise(sight(), np.zeros(COUNT), PLACES + s).pixels for s in (step, -step)
        )
        np.testing.assert_allclose(found.by_place[:, :, axis], (after - before) / 2e-4, atol=1e-4)
    for error in range(COUNT):
        step = 1e-5 * np.eye(COUNT)[error]
        after, before = (linearise(sight(), s, PLACES).pixels for s in (step, -step))
        expected = (after - before) / 2e-5
        np.testing.assert_allclose(found.by_platform[:, :, error], expected, rtol=1e-4, atol=1e-4)


def test_what_lies_behind_the_camera_is_not_seen():
    behind = np.array([[0.0, -40.0]])
    assert linearise(sight(), np.zeros(COUNT), np.vstack([PLACES, behind])).seen.tolist() == [
        1,
        1,
        1,
        0,
    ]
