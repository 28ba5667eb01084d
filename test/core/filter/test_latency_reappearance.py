# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes seen again from a camera that looks down, at a right latency and at wrong ones."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.latency_reappearance import TUNING, Reappearance
from aerial_gnss_ros.core.filter.latency_views import EXPECTED, Views
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT

HEIGHT_M, FOCAL_PX, STEP_S, SPEED_MPS = 18.0, 900.0, 0.5, 0.4
METRE_PX = FOCAL_PX / HEIGHT_M
DOWN = matrix_from_rpy(0.0, 0.5 * math.pi, 0.0)
MIDDLE = np.array([640.0, 360.0])
OFF = np.diag([0.0] * 5 + [0.1**2 / TUNING.lasting, 0.0])
"""Covariance of a heading that counts as off by 0.1 rad."""


def views(*east, north=0.0):
    """Return cameras that look down from so far east and north, m."""
    positions = np.array([[one, north, HEIGHT_M] for one in east])
    return Views(positions, np.broadcast_to(DOWN @ FLU_FROM_OPTICAL, (len(east), 3, 3)))


@pytest.fixture
def seen(sea):
    model = SimpleNamespace(white=np.zeros(6), pixel=1.0, nominal=np.zeros((COUNT, COUNT)))
    found = Reappearance(model, MotionModel(0.0, SPEED_MPS))

    def show(pixels, view, passed=STEP_S):
        return found.update(sea.camera, np.array(pixels).reshape(-1, 2), passed, view)

    return show


def test_the_distance_is_that_of_what_the_camera_moved_too_much(seen):
    assert seen([MIDDLE], views(0.0, 0.0)) is None
    misfit, size = seen([MIDDLE], views(0.0, 0.4))
    variance = (SPEED_MPS * STEP_S * METRE_PX) ** 2 + 2.0
    assert misfit[0] == pytest.approx(-EXPECTED)
    assert misfit[1] == pytest.approx((0.4 * METRE_PX) ** 2 / variance - EXPECTED, rel=1e-6)
    np.testing.assert_allclose(size, 2.0 * math.log(variance))


def test_the_nearest_box_counts_and_far_ones_are_all_alike(seen):
    seen([MIDDLE, MIDDLE + 100.0], views(0.0))
    misfit, _ = seen([MIDDLE + np.array([5.0, 0.0]), MIDDLE + 300.0], views(0.0))
    near = 25.0 / ((SPEED_MPS * STEP_S * METRE_PX) ** 2 + 2.0)
    assert misfit[0] == pytest.approx(0.5 * (near + TUNING.elsewhere_squared) - EXPECTED)


def test_what_should_be_out_of_view_is_not_missed(seen):
    seen([MIDDLE], views(0.0, 0.0))
    misfit, _ = seen([], views(0.0, 40.0))
    np.testing.assert_allclose(misfit, [TUNING.elsewhere_squared - EXPECTED, 0.0], atol=1e-9)


def test_images_far_apart_are_not_compared(seen):
    seen([MIDDLE], views(0.0))
    assert seen([MIDDLE], views(0.0), TUNING.apart_s + 0.1) is None
    assert seen([MIDDLE], views(0.0), 0.1) is not None


def test_an_image_without_boxes_has_none_to_see_again(seen):
    seen([], views(0.0))
    assert seen([MIDDLE], views(0.0)) is None


def test_an_error_that_lasts_shows_places_elsewhere_once_the_camera_moves(sea):
    """A compass off by 0.1 rad: a camera that flies on by 0.4 m sees all 4 cm to the side."""
    model = SimpleNamespace(white=np.zeros(6), pixel=1.0, nominal=OFF)
    found = Reappearance(model, MotionModel(0.0, 0.0))
    sizes = []
    for east in (0.0, 0.4, 0.4):
        told = found.update(sea.camera, MIDDLE[None], STEP_S, views(east))
        sizes.append(None if told is None else float(told[1][0]))
    along = 2.0 + (0.1 * 0.4 * METRE_PX) ** 2
    assert sizes[1:] == pytest.approx([math.log(2.0 * along), math.log(4.0)], rel=1e-3)


def test_an_error_on_both_axes_of_the_image_is_one(sea):
    """As above, but flying north-east: of variances of 2 and 2 a^2 + 2, whichever way it flew."""
    model = SimpleNamespace(white=np.zeros(6), pixel=1.0, nominal=OFF)
    found = Reappearance(model, MotionModel(0.0, 0.0))
    found.update(sea.camera, MIDDLE[None], STEP_S, views(0.0))
    _, size = found.update(sea.camera, MIDDLE[None], STEP_S, views(0.4, north=0.4))
    across = 2.0 + 2.0 * (0.1 * 0.4 * METRE_PX) ** 2
    assert size[0] == pytest.approx(math.log(2.0 * across), rel=1e-3)
