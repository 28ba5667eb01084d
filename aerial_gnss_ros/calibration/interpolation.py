# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Error of poses interpolated between telemetry samples, by cross-validation.

Every sample is interpolated from every other one. That has the errors of interpolation at twice the
spacing, during the same manoeuvres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.ndimage import uniform_filter1d

Array = NDArray[np.float64]

SHARE = 0.5
"""Interpolation error as a share of that at twice the spacing: 0.35 if rates are a random walk, 1
if the motion is faster than the samples."""
WINDOW, WINDOW_S = 5, 2.0
"""Errors are averaged over at least this many samples and this time, s."""
PASSED = 1.64
"""Variance of a sample less its prediction per variance of white noise: 1 and the squares of the
prediction's weights, -1/16, 9/16, 9/16 and -1/16."""


def from_every_other(t: Array, values: Array) -> Array:
    """Return values (n, k) at n times, each interpolated from samples without it."""
    found = values.copy()
    for parity in (0, 1):
        kept = np.arange(len(t)) % 2 != parity
        spline = make_interp_spline(t[kept], values[kept], k=min(3, int(kept.sum()) - 1))
        found[~kept] = spline(t[~kept])
    return found


class InterpolationError:
    """The variance of interpolation as a function of time, piece by piece.

    Args:
        white: (k,) one sigma of the samples' white noise.
    """

    def __init__(self, white: list[float]) -> None:
        self._noise = PASSED * np.square(white)
        self._times: list[Array] = []
        self._variances: list[Array] = []

    def add(self, t: Array, errors: Array) -> None:
        """Add the errors (n, k) of predicting the samples of one piece, in time order."""
        errors = errors.copy()
        errors[0], errors[-1] = errors[1], errors[-2]  # ends are extrapolated, not interpolated
        window = max(WINDOW, round(WINDOW_S / float(np.median(np.diff(t)))))
        squares = uniform_filter1d(errors**2, window, axis=0, mode="nearest")
        self._times.append(t)
        self._variances.append(SHARE**2 * np.maximum(squares - self._noise, 0.0))

    def variance(self, t: Array) -> Array:
        """Return the variance at times (n,), (n, k); 0 where there is no telemetry at all."""
        if not self._times:
            return np.zeros((len(t), len(self._noise)))
        at, table = np.concatenate(self._times), np.concatenate(self._variances)
        return np.stack([np.interp(t, at, column) for column in table.T], axis=1)
