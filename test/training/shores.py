# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A picture of a shore for tests."""

from __future__ import annotations

import numpy as np


def shore(seed=1, size=(240, 320)):
    """Water on the left, stones on the right."""
    rng = np.random.default_rng(seed)
    image = np.full((*size, 3), (70, 90, 80), np.uint8)
    image += rng.integers(0, 6, image.shape, dtype=np.uint8)
    half = size[1] // 2
    image[:, half:] = rng.integers(0, 255, (size[0], size[1] - half, 3))
    return image
