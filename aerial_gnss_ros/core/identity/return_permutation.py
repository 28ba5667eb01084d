# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which is which of robots that have all come up again: by places and absences, all at once."""

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
    """Robots of which all orders are weighed; of more, only exchanges of two. Judged."""


TUNING = ReturnPermutationTuning()


def likeliest_permutation(
    cost: Array,
    possible: NDArray[np.bool_],
    rows: Indices,
    columns: Indices,
    gone: Array,
    absences: AbsenceTimes,
) -> tuple[Indices, Array]:
    """Return the likeliest rows (k,) for the columns of an assignment.

    Besides, by robot (k,) as it is assigned, the probability of each column (k,) to be it, over all
    orders: three robots may be in a ring on one another's places.

    Args:
        cost: (n, m) of a pair: minus twice the log of the likelihood of its place.
        possible: (n, m) pairs that can be.
        rows: k of the assignment.
        columns: theirs.
        gone: (n, m) absences, s.
        absences: their law.
    """
    k = len(rows)
    logs: dict[tuple[int, ...], float] = {}
    for order in _orders(k):
        chosen = rows[list(order)]
        if possible[chosen, columns].all():
            place = -0.5 * float(cost[chosen, columns].sum())
            logs[order] = place + absences.joint_log_density(gone[chosen, columns])
    best = max(logs, key=lambda order: logs[order])
    chances = np.zeros((k, k))
    for order, log in logs.items():
        robots = [order.index(robot) for robot in best]
        chances[range(k), robots] += np.exp(log - logs[best])
    return rows[list(best)], chances / np.maximum(chances.sum(axis=1, keepdims=True), 1e-300)


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
