# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sizes add up over a track, but for boxes that may be cut off."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.georeferencing.size_fit import SizeFit, SizeSums

FIT = SizeFit(
    np.array([0.1, 0.2, 0.4]), np.array([-1.0, -2.0, -3.0]), np.array([0.04, 0.05, 0.06]),
    np.array([0.01, 0.02, 0.03]), np.array([True, False, True]),
)  # fmt: skip


def test_a_box_that_may_be_cut_off_counts_for_nothing():
    assert FIT.of(1) == SizeSums()
    assert FIT.of(0) == SizeSums(1, 0.1, -1.0, 0.04, 0.01)


def test_sums_are_over_the_boxes_of_both():
    both = FIT.of(0) + FIT.of(2) + FIT.of(1)
    assert both == SizeSums(2, 0.5, -4.0, 0.04 + 0.06, 0.04)
