# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the image's middle meets the water, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, yaw_from_heading
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.preflight.pointing import relative_direction, view_center, view_heading


def pose(heading_deg, below_deg, height=10.0):
    yaw = float(yaw_from_heading(math.radians(heading_deg)))
    camera = matrix_from_rpy(0.0, math.radians(below_deg), yaw)
    return CameraPose(0, math.radians(13.0), math.radians(-59.0), height, math.nan, camera)


def test_thirty_degrees_down_meets_the_water_at_height_times_root_three():
    seen = view_center(pose(231.0, 30.0))
    assert seen.distance == pytest.approx(10.0 * math.sqrt(3.0), rel=1e-4)
    assert seen.range_m == pytest.approx(20.0, rel=1e-4)
    assert math.degrees(seen.bearing) == pytest.approx(231.0)
    assert math.degrees(seen.heading) == pytest.approx(231.0)
    distance, azimuth, _ = geodesic_inverse(
        math.radians(13.0), math.radians(-59.0), seen.latitude, seen.longitude
    )
    assert distance == pytest.approx(seen.distance, abs=1e-3)
    assert math.degrees(azimuth) % 360.0 == pytest.approx(231.0, abs=1e-3)


def test_the_middle_of_the_image_is_not_the_principal_point():
    k = np.array([[500.0, 0, 499.5], [0, 500.0, 499.5 - 500.0 * math.tan(math.radians(10.0))],
                  [0, 0, 1]])  # fmt: skip
    seen = view_center(pose(0.0, 30.0), CameraModel(1000, 1000, "plumb_bob", k))
    assert math.degrees(seen.below_horizon) == pytest.approx(40.0)


def test_a_steep_view_has_the_heading_of_the_images_top_and_the_sky_no_water():
    assert math.degrees(view_heading(pose(120.0, 90.0).enu_from_camera)) == pytest.approx(120.0)
    sky = view_center(pose(45.0, -5.0))
    assert math.isnan(sky.distance)
    assert math.degrees(sky.below_horizon) == pytest.approx(-5.0)


@pytest.mark.parametrize(
    ("bearing", "nose", "words"),
    [(10, 350, "ahead"), (90, 0, "to the right"), (200, 20, "behind"), (300, 20, "to the left"),
     (359, 315, "ahead to the right")],
)  # fmt: skip
def test_bearings_in_words(bearing, nose, words):
    assert relative_direction(math.radians(bearing), math.radians(nose)) == words
