# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes may be coming into the picture or leaving it."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.georeferencing.measurements import EDGE, Measurements, at_edge


def test_boxes_at_each_side_are_at_the_edge():
    """1000 x 500 px: 30 px wide."""
    assert EDGE * 500.0 == 30.0
    pixels = np.array([[29.0, 250], [971, 250], [500, 29], [500, 471], [31, 31], [969, 469]])
    assert at_edge(pixels, 1000, 500).tolist() == [True] * 4 + [False] * 2
    assert at_edge(np.zeros((0, 2)), 1000, 500).tolist() == []


def test_measurements_move_with_the_water_they_are_on():
    at = np.array([[1.0, 2.0], [3.0, 4.0]])
    every = np.array([0, 1])
    one = Measurements(
        every, at * 100.0, at, np.zeros((2, 2, 2)), np.array(["a", "a"]), every > 0,
        np.column_stack([at, [-0.1, -0.2]]),
    )  # fmt: skip
    assert one.moved(np.zeros(3)) is one
    moved = one.moved(np.array([5.0, -6.0, 0.0]))
    np.testing.assert_allclose(moved.positions, [[6.0, -4.0], [8.0, -2.0]])
    np.testing.assert_allclose(moved.points, [[6.0, -4.0, -0.1], [8.0, -2.0, -0.2]])
    assert moved.pixels is one.pixels
