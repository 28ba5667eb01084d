# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures are of the wanted size, differ, and bear a robot's colours but not its layout."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.training.figures import figure, reordered

RED_BESIDE_BLUE = np.zeros((40, 40, 3), np.uint8)
RED_BESIDE_BLUE[:, :20] = (0, 0, 200)
RED_BESIDE_BLUE[:, 20:] = (200, 0, 0)


@pytest.mark.parametrize("length", [12.0, 60.0])
def test_figures_have_about_the_length_and_differ(length):
    rng = np.random.default_rng(3)
    extents, areas = [], []
    for _ in range(40):
        share, colours = figure(rng, length)
        assert colours.shape == (*share.shape, 3)
        assert 0.0 <= share.min() <= share.max() <= 1.0
        assert 0.0 <= colours.min() <= colours.max() <= 255.0
        points = np.argwhere(share > 0.3)
        extents.append(np.ptp(points, axis=0).max() if len(points) else 0.0)
        areas.append(float(share.sum()) / length**2)
    assert 0.5 * length < np.median(extents) < 1.3 * length
    assert max(areas) > 4 * np.quantile(areas, 0.1)


def test_half_of_the_figures_of_many_parts_are_symmetric():
    """A symmetric one equals its mirror image about the line to which it was turned."""
    rng = np.random.default_rng(1)
    likeness = []
    for _ in range(60):
        share, _ = figure(rng, 60.0)
        best = 0.0
        middle = (len(share) / 2.0 - 0.5,) * 2
        for angle in range(0, 180, 3):
            turn = cv2.getRotationMatrix2D(middle, angle, 1.0)
            turned = cv2.warpAffine(share, turn, share.shape)
            both = np.minimum(turned, turned[:, ::-1]).sum() / np.maximum(turned.sum(), 1.0)
            best = max(best, float(both))
        likeness.append(best)
    assert 0.2 < np.mean(np.array(likeness) > 0.95) < 0.8


def test_a_picture_in_another_order_keeps_its_colours_and_not_its_halves():
    rng = np.random.default_rng(2)
    halves, hues = [], []
    for _ in range(60):
        made = reordered(rng, RED_BESIDE_BLUE, 60)
        assert made.shape == (60, 60, 3)
        levels = np.sort(made.reshape(-1, 3).mean(axis=0))
        hues.append(levels[0] / levels[2])  # one of three channels stays empty
        left, right = made[:, :30].mean(axis=(0, 1)), made[:, 30:].mean(axis=(0, 1))
        halves.append(np.abs(left - right).max() / made.mean())
    np.testing.assert_allclose(hues, 0.0, atol=1e-6)
    assert np.median(halves) < 1.5  # 3 of the picture itself


def test_the_same_seed_gives_the_same_figure():
    first, second = (figure(np.random.default_rng(7), 40.0, [RED_BESIDE_BLUE]) for _ in range(2))
    np.testing.assert_array_equal(first[0], second[0])
    np.testing.assert_array_equal(first[1], second[1])
