# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes of what a picture shows, and which robots a detector is expected to find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.simulation.labels import (
    MIN_CONTRAST,
    MIN_LONG_PX,
    MIN_SHORT_PX,
    MIN_VISIBLE,
    RobotLabel,
    box_of_points,
    turned_size,
)
from aerial_gnss_ros.simulation.view import Window

IMAGE = Window(0, 0, 100, 60)
LABEL = RobotLabel(
    "aqua_1", "aqua", 10.0, 20.0, 40.0, 30.0, MIN_LONG_PX, MIN_SHORT_PX, 0.5, MIN_CONTRAST,
    MIN_VISIBLE, (25.0, 25.0),
)  # fmt: skip


def test_a_box_is_its_middle_and_its_size():
    assert LABEL.xywh == (25.0, 25.0, 30.0, 10.0)


@pytest.mark.parametrize(
    ("changes", "clear", "scored"),
    [
        ({}, True, True),
        ({"contrast": 0.99 * MIN_CONTRAST}, False, False),
        ({"visible": 0.99 * MIN_VISIBLE}, False, False),
        ({"long_px": 0.99 * MIN_LONG_PX}, True, False),
        ({"short_px": 0.99 * MIN_SHORT_PX}, True, False),
    ],
)
def test_a_robot_is_scored_where_it_is_large_and_clear_enough(changes, clear, scored):
    label = replace(LABEL, **changes)
    assert (label.clear, label.scored, label.figures()["scored"]) == (clear, scored, int(scored))


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 75.0])
def test_a_turned_rectangle_has_its_own_sides(angle_deg):
    a = np.radians(angle_deg)
    turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    corners = np.array([[0, 0], [30, 0], [30, 10], [0, 10], [15, 5]]) @ turn.T + 40.0
    assert turned_size(corners) == pytest.approx((30.0, 10.0), abs=1e-3)


def test_what_leaves_the_image_does_not_widen_the_rest():
    """Of a triangle with its tip 20 px beyond the right edge, what is inside ends at that edge."""
    inside = np.array([[10.0, 10.0], [30.0, 10.0], [30.0, 40.0], [20.0, 20.0]])
    assert box_of_points(inside, IMAGE) == (10.0, 10.0, 30.0, 40.0)
    tip = np.array([[79.5, 20.0], [79.5, 40.0], [119.5, 30.0]])
    assert box_of_points(tip, IMAGE) == pytest.approx((79.5, 20.0, 99.5, 40.0))
    slanted = np.array([[89.5, 10.0], [109.5, 10.0], [109.5, 30.0]])
    assert box_of_points(slanted, IMAGE) == pytest.approx((89.5, 10.0, 99.5, 20.0))
    assert box_of_points(inside + np.array([100.0, 0.0]), IMAGE) is None


@pytest.mark.parametrize(
    ("move", "box"),
    [
        ((-20.0, 0.0), (-0.5, 10.0, 10.0, 40.0)),
        ((0.0, -20.0), (10.0 + 20.0 * 9.5 / 30.0, -0.5, 30.0, 20.0)),
        ((0.0, 30.0), (10.0, 40.0, 30.0, 59.5)),
    ],
)
def test_a_box_ends_half_a_pixel_beyond_the_first_and_the_last_one(move, box):
    corners = np.array([[10.0, 10.0], [30.0, 10.0], [30.0, 40.0]])
    assert box_of_points(corners + move, IMAGE) == pytest.approx(box)
