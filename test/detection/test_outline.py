# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The outline of an object that a rough box touches."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.detection.outline import outlined

ROBOT = np.array([160.0, 120.0, 40.0, 24.0])


@pytest.fixture(name="water")
def _water():
    rng = np.random.default_rng(1)
    noise = cv2.GaussianBlur(rng.normal(0.0, 12.0, (240, 320)), (0, 0), 1.5)[..., None]
    return np.clip(np.array([110.0, 120.0, 70.0]) + noise, 0, 255).astype(np.uint8)


def _draw(image, box, colour):
    low, high = box[:2] - box[2:] / 2, box[:2] + box[2:] / 2 - 1
    cv2.rectangle(image, low.astype(int).tolist(), high.astype(int).tolist(), colour, -1)
    return image


@pytest.mark.parametrize("rough", [(0, 0, 1.0, 1.0), (3, -2, 0.85, 0.85), (-5, 4, 1.3, 1.3)])
def test_a_rough_box_gives_the_outline(water, rough):
    """Shifted by some pixels, a little too small or too large."""
    _draw(water, ROBOT, (40, 210, 230))
    x, y, width, height = rough
    found = outlined(water, ROBOT * (1, 1, width, height) + (x, y, 0, 0))
    np.testing.assert_allclose(found, ROBOT, atol=2.0)
