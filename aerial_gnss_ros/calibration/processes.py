# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Gaussian processes on knots: a linear basis with a Gauss-Markov prior, and robots' paths.

A path is a cubic spline whose velocity is an Ornstein-Uhlenbeck process: a robot that stays is one
whose speed is 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

Array = NDArray[np.float64]
Index = NDArray[np.intp]

PATH_KNOT_S, MOST_PATH = 1.0, 150
VELOCITY_TIME_S = 8.0
"""Correlation time of a robot's velocity, s."""
ANYWHERE_M = 300.0
"""Prior sigma of the position of a path's middle, m."""


@dataclass(frozen=True)
class LinearBasis:
    """Piecewise linear functions on even knots, for each of n times.

    Attributes:
        columns: (n, 2) knots.
        weights: (n, 2) of both functions.
        count: of knots.
        step_s: between them.
    """

    columns: Index
    weights: Array
    count: int
    step_s: float

    @staticmethod
    def of(t: Array, step_s: float, most: int) -> LinearBasis:
        """Return the basis over the span of some times."""
        first, span = float(t.min()), max(float(np.ptp(t)), 1e-3)
        count = int(np.clip(math.ceil(span / step_s - 1e-6) + 1, 2, most))
        at = (t - first) / span * (count - 1)
        low = np.clip(at.astype(np.intp), 0, count - 2)
        share = at - low
        return LinearBasis(
            np.stack([low, low + 1], axis=1), np.stack([1.0 - share, share], axis=1), count,
            span / (count - 1),
        )  # fmt: skip

    def table(self) -> Array:
        """Return (n, count) weights."""
        full = np.zeros((len(self.columns), self.count))
        np.put_along_axis(full, self.columns, self.weights, axis=1)
        return full


@dataclass(frozen=True)
class Path:
    """One robot's path, a cubic spline.

    Attributes:
        rows: boxes of the robot.
        columns: (k, 4) indices of the coefficients at each box, from 0.
        weights: (k, 4).
        count: of coefficients for one axis.
        rough: (count, count) precision for a speed of 1 m/s, one sigma.
        middle: (count,) weights of the coefficients in the middle of the path.
        log_det: of the precision of one axis at 1 m/s.
    """

    rows: Index
    columns: Index
    weights: Array
    count: int
    rough: Array
    middle: Array
    log_det: float

    @staticmethod
    def of(t: Array, rows: Index, knot_s: float = PATH_KNOT_S) -> Path:
        """Return the path of the robot with these boxes."""
        own = t[rows]
        first, span = float(own.min()), max(float(np.ptp(own)), 0.5)
        pieces = int(np.clip(round(span / knot_s), 1, MOST_PATH))
        knots = np.concatenate([[first] * 3, np.linspace(first, first + span, pieces + 1)])
        knots = np.concatenate([knots, [first + span] * 3])
        count = pieces + 3
        basis = BSpline(knots, np.eye(count), 3)
        low = np.clip(((own - first) / span * pieces).astype(np.intp), 0, pieces - 1)
        columns = low[:, None] + np.arange(4)
        weights = np.take_along_axis(basis(np.clip(own, first, first + span)), columns, axis=1)
        nodes, share = np.polynomial.legendre.leggauss(4)
        length = span / pieces
        fine = first + length * (np.arange(pieces)[:, None] + 0.5 * (nodes + 1.0)).ravel()
        velocity, acceleration = basis.derivative(), basis.derivative(2)
        pull = acceleration(fine) + velocity(fine) / VELOCITY_TIME_S
        weight = np.tile(0.5 * length * share, pieces)
        rough = 0.5 * VELOCITY_TIME_S * (pull.T * weight) @ pull
        begin = velocity(np.array([first]))[0]
        rough += np.outer(begin, begin)
        middle = basis(np.array([first + 0.5 * span]))[0]
        whole = rough + np.outer(middle, middle) / ANYWHERE_M**2
        log_det = float(np.linalg.slogdet(whole)[1])
        return Path(rows, columns, weights, count, rough, middle, log_det)


def gauss_markov(basis: LinearBasis, time_s: float) -> tuple[Array, float]:
    """Return the precision of a Gauss-Markov process of sigma 1 at knots, and its determinant."""
    keep = math.exp(-basis.step_s / time_s)
    fresh = 1.0 - keep * keep
    chain = np.diag(np.full(basis.count, 1.0 + keep * keep))
    chain[0, 0] = chain[-1, -1] = 1.0
    chain -= keep * (np.eye(basis.count, k=1) + np.eye(basis.count, k=-1))
    return chain / fresh, -(basis.count - 1) * math.log(fresh)
