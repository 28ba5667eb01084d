# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes may be coming into the picture or leaving it."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.georeferencing.measurements import EDGE, at_edge


def test_boxes_at_each_side_are_at_the_edge():
    """1000 x 500 px: 30 px wide."""
    assert EDGE * 500.0 == 30.0
    pixels = np.array([[29.0, 250], [971, 250], [500, 29], [500, 471], [31, 31], [969, 469]])
    assert at_edge(pixels, 1000, 500).tolist() == [True] * 4 + [False] * 2
    assert at_edge(np.zeros((0, 2)), 1000, 500).tolist() == []
