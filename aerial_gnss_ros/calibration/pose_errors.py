# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors of a measured camera pose, and the axes of its angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ERRORS = ("gnss_east", "gnss_north", "height", "gimbal_roll", "gimbal_pitch", "heading")
"""Corrections: true pose minus measured pose, m, m, m, rad, rad, rad."""


def error_axes_of(rotations: Array) -> Array:
    """Return the axes of `gimbal.error_axes` of many cameras, (n, 3, 3)."""
    east, north = rotations[:, 0, 1], rotations[:, 1, 1]
    rolled = np.hypot(east, north) < 1e-6
    east = np.where(rolled, -rotations[:, 1, 0], east)
    north = np.where(rolled, rotations[:, 0, 0], north)
    length = np.hypot(east, north)
    east, north = east / length, north / length
    axes = np.zeros((len(rotations), 3, 3))
    axes[:, 0, 0], axes[:, 0, 1] = north, east
    axes[:, 1, 0], axes[:, 1, 1] = -east, north
    axes[:, 2, 2] = 1.0
    return axes
