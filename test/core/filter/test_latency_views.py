# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Places that pixels show at several poses, and where they are in the image again."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.filter.latency_views import Views
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy

PIXELS = np.array([[640.0, 360.0], [100.0, 600.0], [1200.0, 50.0]])


def views(*down_deg):
    turns = [matrix_from_rpy(0.0, math.radians(one), 0.3) for one in down_deg]
    positions = np.array([[5.0 * i, 2.0, 30.0] for i in range(len(turns))])
    return Views(positions, np.array(turns) @ FLU_FROM_OPTICAL)


def test_places_are_where_their_pixels_show_them(sea):
    seen = views(60.0, 50.0)
    places, shown = seen.places(sea.camera, PIXELS)
    assert shown.all()
    pixels, _, noise, ahead = seen.measured(sea.camera, places, np.zeros(6))
    assert ahead.all()
    assert not noise.any()
    np.testing.assert_allclose(pixels, np.broadcast_to(PIXELS, pixels.shape), atol=0.01)


def test_a_pixel_of_the_sky_shows_no_place(sea):
    _, shown = views(5.0).places(sea.camera, PIXELS)
    np.testing.assert_array_equal(shown, [[True, True, False]])


def test_the_derivative_by_the_place_and_the_noise_are_those_of_differences(sea):
    seen, white = views(60.0), np.array([0.04, 0.0, 0.0, 0.0, 0.0, 0.0])
    places, _ = seen.places(sea.camera, PIXELS)
    pixels, by_place, noise, _ = seen.measured(sea.camera, places, white)
    east = np.array([1e-4, 0.0])
    moved, _, _, _ = seen.measured(sea.camera, places + east, white)
    by_east = (moved - pixels) / 1e-4
    np.testing.assert_allclose(by_place[..., 0], by_east, rtol=1e-3, atol=1e-3)
    # A camera farther east sees places as if they were farther west.
    np.testing.assert_allclose(
        noise, 0.04 * by_east[..., :, None] * by_east[..., None, :], rtol=1e-3, atol=1e-3
    )


def test_a_pose_between_samples_is_less_certain(sea):
    seen, white = views(60.0, 60.0), np.array([0.04, 0.0, 0.0, 0.0, 0.0, 0.0])
    places, _ = seen.places(sea.camera, PIXELS)
    between = Views(seen.positions, seen.optical, np.outer([0.0, 3.0], white))
    _, _, noise, _ = between.measured(sea.camera, places, white)
    assert noise[0].any()
    np.testing.assert_allclose(noise[1], 4.0 * noise[0], rtol=1e-3)
