# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cubic splines through values at equal steps.

scipy's `CubicSpline` gives the same, but takes half a second to import. On a given grid a spline is
linear in the values, so its weights are computed once.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@lru_cache(maxsize=8)
def spline_weights(count: int, parts: int) -> Array:
    """Return what values at equal steps weigh in those of their spline on a finer grid.

    The spline's third derivative is continuous at the second knot and the last but one ("not a
    knot"; de Boor 1978).

    Args:
        count: n, of the values, at least 4.
        parts: into how many a step is divided.

    Returns:
        (parts (n - 1) + 1, n), read-only.
    """
    # Of the second derivatives, where a step is 1: neighbours of each inner knot, and both ends.
    curves, inner = np.zeros((count, count)), np.arange(1, count - 1)
    values = np.zeros((count, count))
    for offset, curve, value in ((-1, 1.0, 6.0), (0, 4.0, -12.0), (1, 1.0, 6.0)):
        curves[inner, inner + offset], values[inner, inner + offset] = curve, value
    curves[0, :3] = curves[-1, -3:] = 1.0, -2.0, 1.0
    second = np.linalg.solve(curves, values)
    places = np.arange(parts * (count - 1) + 1)
    left = np.minimum(places // parts, count - 2)
    after = (places / parts - left)[:, None]
    before, each = 1.0 - after, np.eye(count)
    weights = before * each[left] + after * each[left + 1]
    weights += (before**3 - before) / 6.0 * second[left]
    weights += (after**3 - after) / 6.0 * second[left + 1]
    weights.flags.writeable = False
    return np.asarray(weights)
