# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Known cameras against calibrations of others."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.camera.catalogue import KNOWN, KnownCamera, known_camera
from aerial_gnss_ros.core.georeferencing.footprint import field_of_view
from aerial_gnss_ros.core.values.errors import CameraError


@pytest.mark.parametrize(
    ("name", "focal_mm", "pixel_mm", "share"),
    [  # focal length from EXIF and pixel pitch as calibrated by Theta-Limited/DroneModels (MIT)
        ("dji_mavic_3", 12.29, 17.902472 / 5280, 0.02),
        ("dji_phantom_4_pro", 8.8, 12.83332 / 5472, 0.03),
        ("dji_mavic_pro", 4.73, 6.32692 / 4000, 0.02),
        ("dji_mini_3_pro", 6.72, 0.0023883764, 0.02),
    ],
)
def test_the_table_agrees_with_calibrations_of_others(name, focal_mm, pixel_mm, share):
    assert KNOWN[name].camera().K[0, 0] == pytest.approx(focal_mm / pixel_mm, rel=share)


def test_images_show_the_photo_as_far_as_their_shape_goes():
    known = known_camera("DJI Mavic-3")
    photo, video, narrow = known.camera(), known.camera((3840, 2160)), known.camera((2000, 2000))
    # 16:9 keeps the photo's full width.
    assert field_of_view(video).horizontal == pytest.approx(field_of_view(photo).horizontal)
    assert field_of_view(narrow).vertical == pytest.approx(field_of_view(photo).vertical, rel=1e-6)
    assert known.camera(zoom=2.0).K[0, 0] == pytest.approx(2.0 * photo.K[0, 0])


@pytest.mark.parametrize(
    ("image", "cropped"),
    [((4000, 3000), False), ((2000, 1500), False), ((1600, 1190), False), ((1600, 1212), False),
     ((1920, 1080), True), ((1600, 1180), True), ((1600, 1220), True)],
)  # fmt: skip
def test_an_image_is_cropped_if_its_shape_is_off_by_a_hundredth(image, cropped):
    known = KnownCamera("x", "Maker X", 24.0, (4000, 3000), 30.0)
    assert known.is_cropped(image) is cropped
    stated = 30.0 if cropped else 24.0
    same = KnownCamera("y", "Maker Y", stated, (4000, 3000))
    assert known.camera(image).K[0, 0] == same.camera(image).K[0, 0]


def test_names_are_found_as_people_write_them():
    assert known_camera(" dji  MAVIC-3_").name == "dji_mavic_3"
    assert known_camera("parrot anafi").source == "Parrot's specifications of the Parrot ANAFI"
    with pytest.raises(CameraError, match="did you mean dji_mavic_3"):
        known_camera("dji mavic3")
    with pytest.raises(CameraError, match="'kite' is not a known camera; known are dji"):
        known_camera("kite")
