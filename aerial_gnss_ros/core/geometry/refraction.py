# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Refraction: robots below the surface are not where the straight ray meets the water.

Snell's law with a ray of unit direction d, s its horizontal part, t its angle from the vertical:
sin t = |s|, sin t_w = |s| / n. Below the surface a robot at depth z lies z tan t_w farther along s:
offset = z s / sqrt(n² - |s|²). At 60 deg and 1 m depth that is 0.85 m.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WATER_INDEX = 1.34
"""Refractive index of sea water for visible light (Mobley, Light and Water, 1994); 1.333 for fresh
water changes the offset by 0.7 %."""


def submerged_offsets(
    directions: Array, depths: Array, index: float = WATER_INDEX
) -> tuple[Array, Array]:
    """Return the offsets of submerged points from where their rays meet the surface.

    Args:
        directions: (n, 3) unit rays in air, East, North, Up; downward.
        depths: (n,) of the points below the surface, m, 0 or more.
        index: refractive index of the water.

    Returns:
        offsets (n, 2) East, North in m, and their derivative (n, 2, 2) by the rays' East and North.
    """
    level = directions[:, :2]
    inverse = 1.0 / np.sqrt(index**2 - np.sum(level * level, axis=1))
    slope = level * inverse[:, None]
    by_level = slope[:, :, None] * slope[:, None, :] + np.eye(2)
    return depths[:, None] * slope, (depths * inverse)[:, None, None] * by_level


def depth_slopes(directions: Array, index: float = WATER_INDEX) -> Array:
    """Return the shift of points per metre of depth, (n, 2) East, North; 0 for invalid rays."""
    offsets, _ = submerged_offsets(np.nan_to_num(directions), np.ones(len(directions)), index)
    return offsets
