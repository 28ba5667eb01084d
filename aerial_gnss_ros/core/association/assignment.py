# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Global nearest neighbour assignment of measurements to tracks, by likelihood.

Feasible pairs are few and are kept as lists of row and column. Only pairs that share a row or a
column with others need an optimisation.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]

_FORBIDDEN = 1e9


@dataclass(frozen=True)
class AssignmentTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    near_gate_radii: float = 3.0
    """Radius of the neighbourhood of a gate, as a multiple of the gate's radius. Judged."""


TUNING = AssignmentTuning()


def assign(squared: Array, log_determinant: Array, allowed: Mask, threshold: float) -> Pairs:
    """Return rows and columns of the assignment with the greatest total likelihood.

    Args:
        squared: (n, m) squared Mahalanobis distances.
        log_determinant: (n, m) log determinants of their covariances.
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
    """Return the indices of the assignment of k pairs with the greatest likelihood, by row.

    The cost of a pair is its squared distance plus log determinant (minus twice its log
    likelihood), so a well-known track takes precedence over one that could be anywhere. An
    unassigned track costs as much as one at the edge of its gate, so that it does not take a
    neighbour's better measurement only to get one itself.

    Args:
        rows: (k,) of pairs inside the gate and of one class, in ascending order.
        columns: (k,) of these pairs.
        squared: (k,) squared Mahalanobis distances.
        log_determinant: (k,) log determinants of their covariances.
        threshold: squared distance at the edge of the gate.
    """
    if len({*rows}) == len({*columns}) == len(rows):  # no conflict
        return [k for k, near in enumerate(squared) if near <= threshold]
    missing: dict[int, float] = {}
    for row, wide in zip(rows, log_determinant, strict=True):
        missing[row] = max(missing.get(row, -math.inf), threshold + wide)
    cost = [near + wide for near, wide in zip(squared, log_determinant, strict=True)]
    return _least(rows, columns, cost, missing)


def cheapest(cost: Array, allowed: Mask, missing: Array) -> Pairs:
    """Return rows and columns of the assignment of least cost, including unassigned rows.

    Args:
        cost: (n, m) of a pair.
        allowed: (n, m) feasible pairs.
        missing: (n,) cost of an unassigned row.
    """
    rows, columns = np.nonzero(allowed)
    left_out = dict(enumerate(missing.tolist()))
    chosen = _least(rows.tolist(), columns.tolist(), cost[allowed].tolist(), left_out)
    return rows[chosen], columns[chosen]


def _least(
    rows: list[int], columns: list[int], cost: list[float], missing: dict[int, float]
) -> list[int]:
    """Return the indices of the assignment of k pairs of least cost, by row.

    Args:
        rows: (k,) of the pairs, in ascending order.
        columns: (k,) theirs.
        cost: (k,) theirs.
        missing: cost of each unassigned row.
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
    _, picked = linear_sum_assignment(costs)
    return [rest[k] for k in np.flatnonzero(picked[i] == j)]


def lone(rows: list[int], columns: list[int]) -> list[bool]:
    """Return which of k pairs are the only ones of their row and column."""
    if len({*rows}) == len(rows) and len({*columns}) == len(columns):
        return [True] * len(rows)
    of, to = Counter(rows), Counter(columns)
    return [of[row] == 1 and to[column] == 1 for row, column in zip(rows, columns, strict=True)]
