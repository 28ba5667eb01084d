# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Focal lengths as makers state them, with numbers that a pocket calculator gives."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.camera.equivalent_focal_length import from_equivalent
from aerial_gnss_ros.core.georeferencing.footprint import field_of_view
from aerial_gnss_ros.core.values.errors import CameraError

PHOTO = (4000, 3000)


def test_it_keeps_the_diagonal_view_of_the_photo():
    # 24 mm on film: 2 atan(43.267 / 48) = 84 deg, which is what DJI states beside it.
    view = field_of_view(from_equivalent(24.0, PHOTO, PHOTO))
    assert math.degrees(view.diagonal) == pytest.approx(84.06, abs=0.02)


@pytest.mark.parametrize(
    ("image", "focal_px"),
    [  # the photo's diagonal is 5000 px: 24 mm are 5000 / 43.267 * 24 = 2773.5 px of it
        (PHOTO, 2773.5),
        ((2000, 1500), 2773.5 / 2),
        ((2000, 1125), 2773.5 / 2),  # 16:9 shows the photo's full width
        ((1500, 1500), 2773.5 / 2),  # a square its full height
        ((1000, 1500), 2773.5 / 2),
    ],
)
def test_an_image_of_another_shape_shows_a_part_of_the_photo(image, focal_px):
    camera = from_equivalent(24.0, PHOTO, image)
    assert camera.K[0, 0] == pytest.approx(focal_px, rel=1e-4)
    assert camera.K[1, 1] == pytest.approx(focal_px, rel=1e-4)
    assert from_equivalent(24.0, PHOTO, image, 3.0).K[0, 0] == pytest.approx(3 * camera.K[0, 0])


@pytest.mark.parametrize("zoom", [0.0, -1.0, math.nan, math.inf])
def test_a_zoom_is_a_positive_number(zoom):
    with pytest.raises(CameraError, match=r"zoom must be above 0"):
        from_equivalent(24.0, PHOTO, PHOTO, zoom)
