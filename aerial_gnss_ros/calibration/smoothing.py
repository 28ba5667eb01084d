# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Smoothing splines that pass motion and suppress errors between samples.

Second differences over a time h have the variance 2 q h + 6 w² if they are errors with a drift of q
per second and white noise w. The cubic smoothing spline passes what is slower than the shortest h
over which the differences clearly exceed that variance, like a Wiener filter.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline, make_smoothing_spline
from scipy.ndimage import uniform_filter1d

Array = NDArray[np.float64]

LEAST_SAMPLES = 6
CLEARLY, WINDOW = 4.0, 12
"""Second differences are motion if their mean square over WINDOW lags is CLEARLY times that of
errors."""


class PiecewiseSpline:
    """A smooth function of time through noisy samples, undefined within gaps.

    Args:
        t: (n,) times, s, increasing.
        values: (n, k).
        max_gap_s: samples farther apart are not joined.
        smoothed: returns a spline through one piece.
    """

    def __init__(
        self, t: Array, values: Array, max_gap_s: float, smoothed: Callable[[Array, Array], BSpline]
    ) -> None:
        ends = np.flatnonzero(np.diff(t) > max_gap_s) + 1
        self._pieces: list[tuple[float, float, BSpline, BSpline]] = []
        for one, piece in zip(np.split(t, ends), np.split(values, ends), strict=True):
            if len(one) >= LEAST_SAMPLES:
                spline = smoothed(one, piece)
                self._pieces.append((float(one[0]), float(one[-1]), spline, spline.derivative()))
        self._width = values.shape[1]

    def at(self, t: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return values (n, k), their rates a second, and where they are known (n,)."""
        values, rates = np.zeros((2, len(t), self._width))
        known = np.zeros(len(t), dtype=np.bool_)
        for first, last, spline, rate in self._pieces:
            inside = (t >= first) & (t <= last)
            values[inside], rates[inside] = spline(t[inside]), rate(t[inside])
            known |= inside
        return values, rates, known


def adapted(
    t: Array, values: Array, errors: list[tuple[float, float]]
) -> tuple[BSpline, list[float]]:
    """Return a spline of the motion in values (n, k), and the median smoothing time of each, s.

    The smoothing time is chosen at each time from the second differences around it: flights have
    calm parts.

    Args:
        t: (n,) times, s.
        values: (n, k).
        errors: of each column: growth of the drift's variance per second, one sigma of white noise.
    """
    spread = float(np.median(np.diff(t)))
    grid = np.arange(t[0], t[-1] + 0.5 * spread, spread)
    lags = 2 ** np.arange(max(1, int(math.log2(max(len(grid) // 8, 1))) + 1), dtype=np.int64)
    columns, times_s = [], []
    for column, error in zip(values.T, errors, strict=True):
        shares = np.array(
            [np.interp(t, grid, one) for one in _levels(grid, t, column, error, lags)]
        )
        smooth = [
            make_smoothing_spline(t, column, lam=penalty(t, float(lag) * spread))(t)
            if share.max() > 1e-3
            else column
            for lag, share in zip(lags, shares, strict=True)
        ]
        columns.append(np.sum(shares * np.array(smooth), axis=0))
        times_s.append(float(2.0 ** np.median(np.log2(lags) @ shares)) * spread)
    return make_interp_spline(t, np.stack(columns, axis=1), k=3), times_s


def _levels(
    grid: Array, t: Array, column: Array, error: tuple[float, float], lags: NDArray[np.int64]
) -> Array:
    """Return the weight of each lag's smoothing at each time of an even grid, (lags, n).

    It selects the shortest lag whose second differences clearly exceed the errors.
    """
    even, spread = np.interp(grid, t, column), float(grid[1] - grid[0])
    level = np.full(len(grid), len(lags) - 1)
    for number in reversed(range(len(lags))):
        lag = int(lags[number])
        bend = np.zeros(len(grid))
        if 2 * lag < len(grid):
            bend[lag:-lag] = even[2 * lag :] - 2.0 * even[lag:-lag] + even[: -2 * lag]
            bend[:lag], bend[-lag:] = bend[lag], bend[-lag - 1]
        noise = 2.0 * error[0] * lag * spread + 6.0 * error[1] ** 2
        around = uniform_filter1d(bend**2, WINDOW * lag, mode="nearest")
        level[around > CLEARLY * noise] = number
    chosen = (level == np.arange(len(lags))[:, None]).astype(np.float64)
    widths = np.maximum(2 * lags[level], 1)
    blur = int(np.median(widths))
    blurred: Array = uniform_filter1d(chosen, blur, axis=1, mode="nearest")
    return blurred


def penalty(t: Array, shortest_s: float) -> float:
    """Return the penalty on squared curvature that halves bends over a given time.

    A smoothing spline passes 1 / (1 + p (2 pi f)^4 dt) of a frequency f, and a bend over a time h
    has f = 1 / 2h.
    """
    return (shortest_s / math.pi) ** 4 / float(np.median(np.diff(t)))


def penalised(t: Array, values: Array, penalties: Array) -> BSpline:
    """Return a smoothing spline of values (n, k), each with its penalty (k,)."""
    columns = [
        make_smoothing_spline(t, column, lam=float(one))
        for column, one in zip(values.T, penalties, strict=True)
    ]
    return BSpline(columns[0].t, np.stack([one.c for one in columns], axis=1), 3)
