# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blurs do what their names say."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.training import pixel_operations as pixels


def scene():
    rng = np.random.default_rng(3)
    return cv2.resize(rng.integers(0, 256, (40, 60, 3), dtype=np.uint8), (240, 160))


@pytest.mark.parametrize("name", ["motion_blur", "gaussian_blur"])
def test_blur_takes_detail_and_keeps_brightness(name):
    rng = np.random.default_rng(0)
    before = scene()
    for _ in range(20):
        after = getattr(pixels, name)(rng, before)
        assert after.shape == before.shape
        assert abs(after.mean() - before.mean()) < 1.0
        assert cv2.Laplacian(after, cv2.CV_64F).var() < cv2.Laplacian(before, cv2.CV_64F).var()


def test_glass_blur_mixes_neighbours_and_nothing_further_away():
    rng = np.random.default_rng(0)
    before = np.full((60, 80, 3), 50, np.uint8)
    before[:, 40:] = 200
    for _ in range(10):
        after = pixels.glass_blur(rng, before)
        far = pixels.GLASS_PX[1] + 2 * 4  # two blurs of at most 1.2 px reach 4 px each
        np.testing.assert_array_equal(after[:, : 40 - far], 50)
        np.testing.assert_array_equal(after[:, 40 + far :], 200)
        assert after[:, 39:41].std() > 5.0  # ragged along the edge
        assert abs(after.mean() - 125.0) < 2.0


def test_motion_blur_smears_along_one_line():
    dot = np.zeros((41, 41, 3), np.uint8)
    dot[20, 20] = 255
    rng = np.random.default_rng(1)
    for _ in range(20):
        v, u = np.nonzero(pixels.motion_blur(rng, dot)[..., 0])
        spread = np.linalg.svd(np.stack([u - 20.0, v - 20.0]), compute_uv=False)
        assert spread[1] <= 1.5 * np.sqrt(len(u))  # no wider than an antialiased line
        assert np.hypot(u - 20.0, v - 20.0).max() <= 9.0  # half of 15 px, and a soft end
