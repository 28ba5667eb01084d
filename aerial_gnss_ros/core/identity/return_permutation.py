# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Likeliest permutation of robots that have all surfaced, by positions and absences jointly."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.identity.return_time import AbsenceTimes

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ReturnPermutationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    permuted_robots: int = 5
    """Up to this many robots all permutations are compared; beyond, only exchanges of two.
    Judged."""


TUNING = ReturnPermutationTuning()


def likeliest_permutation(
    cost: Array,
    possible: NDArray[np.bool_],
    rows: Indices,
    columns: Indices,
    absence_s: Array,
    distribution: AbsenceTimes,
) -> tuple[Indices, Array]:
    """Return the likeliest rows (k,) for the columns of an assignment.

    Also returns, for each assigned robot (k,), the probability of each column (k,) over all
    permutations: three robots may be permuted cyclically.

    Args:
        cost: (n, m) of a pair: minus twice the log likelihood of its position.
        possible: (n, m) pairs that are possible.
        rows: k of the assignment.
        columns: theirs.
        absence_s: (n, m) absences, s.
        distribution: distribution of absences.
    """
    k = len(rows)
    logs: dict[tuple[int, ...], float] = {}
    for order in _orders(k):
        chosen = rows[list(order)]
        if possible[chosen, columns].all():
            place = -0.5 * float(cost[chosen, columns].sum())
            logs[order] = place + distribution.joint_log_density(absence_s[chosen, columns])
    best = max(logs, key=lambda order: logs[order])
    probabilities = np.zeros((k, k))
    for order, log in logs.items():
        robots = [order.index(robot) for robot in best]
        probabilities[range(k), robots] += np.exp(log - logs[best])
    return rows[list(best)], probabilities / np.maximum(
        probabilities.sum(axis=1, keepdims=True), 1e-300
    )


def _orders(k: int) -> list[tuple[int, ...]]:
    if k <= TUNING.permuted_robots:
        return list(permutations(range(k)))
    every = list(range(k))
    found = [tuple(every)]
    for a, b in combinations(range(k), 2):
        order = every.copy()
        order[a], order[b] = b, a
        found.append(tuple(order))
    return found
