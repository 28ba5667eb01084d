# SPDX-License-Identifier: Apache-2.0
"""Which measurement belongs to which track: the best assignment over all pairs at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Array = NDArray[np.float64]
Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]

_FORBIDDEN = 1e9


NEAR = 3.0
"""Just outside a gate: up to so many times its radius."""


def gate_threshold(probability: float) -> float:
    """Return the squared Mahalanobis distance that holds a share of a planar normal law.

    The chi-square law with two degrees of freedom has a closed form.
    """
    return -2.0 * math.log1p(-probability)


def mahalanobis(offsets: Array, covariances: Array) -> tuple[Array, Array]:
    """Return squared Mahalanobis lengths and log determinants of planar offsets.

    Args:
        offsets: (..., 2) m.
        covariances: (..., 2, 2) m².
    """
    a, b, d = covariances[..., 0, 0], covariances[..., 0, 1], covariances[..., 1, 1]
    determinant = np.maximum(a * d - b * b, 1e-24)
    x, y = offsets[..., 0], offsets[..., 1]
    squared = (d * x * x - 2.0 * b * x * y + a * y * y) / determinant
    return squared, np.log(determinant)


def assign(
    squared: Array, log_determinant: Array, allowed: NDArray[np.bool_], threshold: float
) -> Pairs:
    """Return rows and columns of the pairs with the largest likelihood in total.

    The cost of a pair is its squared distance plus log determinant (minus twice the log
    likelihood), so that a track whose place is well known goes before one that could be anywhere.
    A track without a measurement costs as much as one at the edge of its gate: it does not push a
    neighbour off the better measurement only to have one itself.

    Args:
        squared: (n, m) squared Mahalanobis distances.
        log_determinant: (n, m) of the covariances they were taken with.
        allowed: (n, m) pairs inside the gate and of one class.
        threshold: squared distance at the edge of the gate.
    """
    widest = np.max(np.where(allowed, log_determinant, -np.inf), axis=1, initial=-np.inf)
    return cheapest(squared + log_determinant, allowed, threshold + widest)


def cheapest(cost: Array, allowed: NDArray[np.bool_], missing: Array) -> Pairs:
    """Return rows and columns of the pairs that cost least together with the rows left out.

    Args:
        cost: (n, m) of a pair.
        allowed: (n, m) pairs that can be.
        missing: (n,) cost of a row without a column.
    """
    none = np.zeros(0, np.intp)
    rows, columns = np.flatnonzero(allowed.any(axis=1)), np.flatnonzero(allowed.any(axis=0))
    if not len(rows):
        return none, none
    inside = np.ix_(rows, columns)
    without = np.full((len(rows), len(rows)), _FORBIDDEN)
    np.fill_diagonal(without, missing[rows])
    costs = np.hstack([np.where(allowed[inside], cost[inside], _FORBIDDEN), without])
    picked_rows, picked_columns = linear_sum_assignment(costs)
    made = picked_columns < len(columns)
    return rows[picked_rows[made]], columns[picked_columns[made]]


def lone_pairs(allowed: NDArray[np.bool_]) -> Pairs:
    """Return rows and columns of the pairs that are the only ones of their row and column."""
    lone = allowed & (allowed.sum(axis=0) == 1)[None] & (allowed.sum(axis=1) == 1)[:, None]
    rows, columns = np.nonzero(lone)
    return rows, columns


def near_misses(
    squared: Array, rows: NDArray[np.intp], columns: NDArray[np.intp], threshold: float
) -> int:
    """Return how many tracks without a measurement have a free one just outside their gate.

    Args:
        squared: (n, m) squared Mahalanobis distances; infinite where a pair is impossible.
        rows: tracks that have a measurement.
        columns: theirs.
        threshold: squared distance at the edge of the gate.
    """
    free = np.delete(np.delete(squared, rows, axis=0), columns, axis=1)
    return int((free <= NEAR**2 * threshold).any(axis=1).sum())
