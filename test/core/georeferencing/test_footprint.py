# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Field of view and ground sample distance, with numbers that a pocket calculator gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.georeferencing.footprint import field_of_view, ground_samples
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
