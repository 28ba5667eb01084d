# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which measurement belongs to which track: the best assignment over all pairs at once.

Pairs that can be are few, so they are kept as lists: row and column of each. Only those that share
a row or a column with others are weighed against one another.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]

_FORBIDDEN = 1e9


@dataclass(frozen=True)
class AssignmentTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    near_gate_radii: float = 3.0
    """Just outside a gate: up to so many times its radius. Judged."""
    clear_ratio: float = 20.0
    """Ratio of the likelihoods of two robots from which a new track is one of them, not the other.
    Odds of 20 to 1, as everywhere."""


TUNING = AssignmentTuning()


def assign(squared: Array, log_determinant: Array, allowed: Mask, threshold: float) -> Pairs:
    """Return rows and columns of the pairs with the largest likelihood in total.

    Args:
        squared: (n, m) squared Mahalanobis distances.
        log_determinant: (n, m) of the covariances they were taken with.
        allowed: (n, m) pairs inside the gate and of one class.
        threshold: squared distance at the edge of the gate.
    """
    rows, columns = np.nonzero(allowed)
    pairs = rows.tolist(), columns.tolist()
    chosen = likeliest(
        *pairs, squared[allowed].tolist(), log_determinant[allowed].tolist(), threshold
    )
    return rows[chosen], columns[chosen]


def likeliest(
    rows: list[int],
    columns: list[int],
    squared: list[float],
    log_determinant: list[float],
    threshold: float,
) -> list[int]:
    """Return which of k pairs have the largest likelihood in total, by row.

    The cost of a pair is its squared distance plus log determinant (minus twice the log
    likelihood), so that a track whose place is well known goes before one that could be anywhere.
    A track without a measurement costs as much as one at the edge of its gate: it does not push a
    neighbour off the better measurement only to have one itself.

    Args:
        rows: (k,) of pairs inside the gate and of one class, in rising order.
        columns: (k,) theirs.
        squared: (k,) squared Mahalanobis distances.
        log_determinant: (k,) of the covariances they were taken with.
        threshold: squared distance at the edge of the gate.
    """
    if len({*rows}) == len({*columns}) == len(rows):  # nothing to weigh
        return [k for k, near in enumerate(squared) if near <= threshold]
    missing: dict[int, float] = {}
    for row, wide in zip(rows, log_determinant, strict=True):
        missing[row] = max(missing.get(row, -math.inf), threshold + wide)
    cost = [near + wide for near, wide in zip(squared, log_determinant, strict=True)]
    return _least(rows, columns, cost, missing)


def cheapest(cost: Array, allowed: Mask, missing: Array) -> Pairs:
    """Return rows and columns of the pairs that cost least together with the rows left out.

    Args:
        cost: (n, m) of a pair.
        allowed: (n, m) pairs that can be.
        missing: (n,) cost of a row without a column.
    """
    rows, columns = np.nonzero(allowed)
    left_out = dict(enumerate(missing.tolist()))
    chosen = _least(rows.tolist(), columns.tolist(), cost[allowed].tolist(), left_out)
    return rows[chosen], columns[chosen]


def _least(
    rows: list[int], columns: list[int], cost: list[float], missing: dict[int, float]
) -> list[int]:
    """Return which of k pairs cost least together with the rows left out, by row.

    Args:
        rows: (k,) of the pairs, in rising order.
        columns: (k,) theirs.
        cost: (k,) theirs.
        missing: cost of each row without a column.
    """
    alone = lone(rows, columns)
    chosen = [k for k, row in enumerate(rows) if alone[k] and cost[k] <= missing[row]]
    rest = [k for k, single in enumerate(alone) if not single]
    if rest:
        chosen = sorted(chosen + _weighed(rest, rows, columns, cost, missing))
    return chosen


def _weighed(
    rest: list[int],
    rows: list[int],
    columns: list[int],
    cost: list[float],
    missing: dict[int, float],
) -> list[int]:
    """Return the cheapest of those pairs that share a row or a column with others."""
    own, i = np.unique([rows[k] for k in rest], return_inverse=True)
    theirs, j = np.unique([columns[k] for k in rest], return_inverse=True)
    every = np.arange(len(own))
    costs = np.full((len(own), len(theirs) + len(own)), _FORBIDDEN)
    costs[every, len(theirs) + every] = [missing[row] for row in own.tolist()]
    costs[i, j] = [cost[k] for k in rest]
    _, picked = solver()(costs)
    return [rest[k] for k in np.flatnonzero(picked[i] == j)]


def solver() -> Callable[[Array], Pairs]:
    """Return scipy's `linear_sum_assignment`, which is seldom needed and takes long to import."""
    from scipy.optimize import linear_sum_assignment

    found: Callable[[Array], Pairs] = linear_sum_assignment
    return found


def lone(rows: list[int], columns: list[int]) -> list[bool]:
    """Return which of k pairs are the only ones of their row and column."""
    if len({*rows}) == len(rows) and len({*columns}) == len(columns):
        return [True] * len(rows)
    of, to = Counter(rows), Counter(columns)
    return [of[row] == 1 and to[column] == 1 for row, column in zip(rows, columns, strict=True)]
