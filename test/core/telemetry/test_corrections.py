# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Corrections: true = measured + correction, East-North-Up, counter-clockwise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.telemetry.corrections import corrected_camera, scaled_camera
from aerial_gnss_ros.simulation.experiment import default_camera


def test_pitch_looks_farther_down_and_heading_turns_left() -> None:
    level = matrix_from_rpy(0.0, math.radians(30), 0.0)  # looks east, 30 deg down
    turned = corrected_camera(level, np.array([0.0, math.radians(5), math.radians(10)]))
    assert math.degrees(math.atan2(turned[1, 0], turned[0, 0])) == pytest.approx(10.0, abs=0.5)
    assert math.degrees(math.asin(-turned[2, 0])) == pytest.approx(35.0, abs=0.5)


def test_heading_also_turns_a_camera_that_looks_straight_down() -> None:
    down = matrix_from_rpy(0.0, 0.5 * math.pi, 0.3)
    turned = corrected_camera(down, np.array([0.0, 0.0, 0.2]))
    np.testing.assert_allclose(turned, matrix_from_rpy(0.0, 0.5 * math.pi, 0.5), atol=1e-12)


def test_focal_scale_spreads_pixels_about_the_principal_point() -> None:
    camera = default_camera(1280, 720)
    longer = scaled_camera(camera, 1.1)
    points = np.array([[0.1, -0.05, 1.0]])
    middle = camera.K[:2, 2]
    spread = (longer.project(points)[0] - middle) / (camera.project(points)[0] - middle)
    np.testing.assert_allclose(spread, 1.1)
