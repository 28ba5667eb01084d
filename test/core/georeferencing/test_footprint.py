# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Field of view and ground sample distance, with numbers that a pocket calculator gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.georeferencing.footprint import field_of_view, ground_samples, outline
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import CameraError


def pinhole(width=1000, height=1000, f=500.0):
    k = [[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1]]
    return CameraModel(width, height, "plumb_bob", np.array(k))


def test_a_square_image_of_half_its_width_focal_length_sees_90_degrees():
    view = field_of_view(pinhole())
    assert math.degrees(view.horizontal) == pytest.approx(90.0)
    assert math.degrees(view.vertical) == pytest.approx(90.0)
    assert math.degrees(view.diagonal) == pytest.approx(2 * math.degrees(math.atan(math.sqrt(2))))


def test_a_pixel_straight_below_covers_height_over_focal_length():
    centre, top, bottom = ground_samples(pinhole(), 20.0, math.pi / 2)
    assert centre.across == pytest.approx(20.0 / 500.0, rel=1e-5)
    assert centre.along == pytest.approx(20.0 / 500.0, rel=1e-5)
    assert centre.distance == pytest.approx(0.0, abs=1e-6)
    for edge in (top, bottom):  # on a plane, a vertical view has one scale everywhere
        assert edge.across == pytest.approx(0.04, rel=1e-4)
        assert edge.distance == pytest.approx(20.0 * 499.5 / 500.0, rel=1e-4)


def test_a_tilted_view_stretches_along_the_column():
    centre, top, _ = ground_samples(pinhole(), 10.0, math.radians(30.0))
    assert centre.range_m == pytest.approx(20.0, rel=1e-4)
    assert centre.distance == pytest.approx(10.0 * math.sqrt(3.0), rel=1e-4)
    assert centre.across == pytest.approx(20.0 / 500.0, rel=1e-4)
    assert centre.along == pytest.approx(20.0 / 500.0 / math.sin(math.radians(30.0)), rel=1e-4)
    assert math.isnan(top.distance)  # 45 deg above the axis: sky
    assert math.degrees(top.below_horizon) == pytest.approx(30.0 - 44.97, abs=0.01)


@pytest.mark.parametrize(("height", "tilt"), [(0.0, 1.0), (math.nan, 1.0), (10.0, 2.0)])
def test_impossible_views_are_refused(height, tilt):
    with pytest.raises(CameraError, match="must"):
        ground_samples(pinhole(), height, tilt)


def pose_at(height, tilt_deg, heading_deg=0.0):
    """Return a camera whose image's top is to the heading, deg clockwise from north."""
    tilt, yaw = math.radians(tilt_deg), math.radians(90.0 - heading_deg)
    orientation = matrix_from_rpy(0.0, tilt, yaw)
    return CameraPose(0, 0.2, -1.0, height, height, orientation)


def east_north(places, pose):
    radius = 6_371_000.0
    east = (places[:, 1] - pose.longitude) * math.cos(pose.latitude) * radius
    return np.stack([east, (places[:, 0] - pose.latitude) * radius], axis=-1)


def test_the_outline_of_a_view_straight_down_is_the_square_that_it_covers():
    pose = pose_at(20.0, 90.0)
    corners = east_north(outline(pose, pinhole(), 1000.0), pose)[::4]
    half = 20.0 * 499.5 / 500.0
    # From the image's top left corner, which is north-west of a camera with its top to the north.
    expected = half * np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
    assert corners == pytest.approx(expected, rel=0.01)


def test_the_outline_ends_where_the_sky_or_the_range_begins():
    pose = pose_at(10.0, 30.0, heading_deg=90.0)
    found = east_north(outline(pose, pinhole(), 100.0), pose)
    distance = np.hypot(*found.T)
    assert 60.0 < distance.max() <= 100.0
    assert found[:, 0].min() == pytest.approx(10.0 / math.tan(math.radians(75.0)), rel=0.02)
    assert (found[:, 0] > 0.0).all()


def test_a_view_of_the_sky_has_no_outline():
    assert outline(pose_at(10.0, -60.0), pinhole(), 100.0).shape == (0, 2)
