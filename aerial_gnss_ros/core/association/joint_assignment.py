# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Assignment of all boxes of an image together, where an error of its pose moves them all alike.

Pairs judged by themselves are exchanged where that error is as large as robots are apart: each
robot takes the box that the displaced neighbour left. But the error is one: a pair that is right
says where the boxes of all others must be. With offsets d of an assignment's pairs and their joint
covariance K (cross-covariances included), the cost of the assignment is

    d' K⁻¹ d + log det K,

minus twice its log likelihood (joint compatibility: Neira and Tardós 2001). Each pair in turn is
taken for right, unless an earlier one has suggested it, and suggests the likeliest assignment of
the others given its offset; the cheapest of these is chosen. A box outside its robot's gate is the
robot's if it is inside given that offset.

What tracking in the image says of each pair is added. It knows nothing of the pose's errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import likeliest
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointAssignmentTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_joint_pairs: int = 128
    """Pairs beyond which each is judged by itself, because of the cost. Judged."""
    suggesting_pairs: int = 30
    """The nearest pairs, up to this number, suggest an assignment each. Judged."""
    joint_rounding: float = 1e-9
    """Share of the largest variance by which a covariance may fail to be positive definite."""


TUNING = JointAssignmentTuning()


def jointly_likeliest(
    rows: list[int],
    columns: list[int],
    offsets: Array,
    covariance: Array,
    threshold: float,
    image_cost: Array,
) -> list[int]:
    """Return the indices of the assignment of k pairs with the greatest joint likelihood.

    Args:
        rows: (k,) of pairs inside the gate or near it, and of one class, in ascending order.
        columns: (k,) of these pairs.
        offsets: (k, 2) from robot to box, m.
        covariance: (2 k, 2 k) of these, m².
        threshold: squared distance at the edge of a gate.
        image_cost: (k,) minus twice the log likelihood of pairs by tracking in the image.
    """
    k = len(rows)
    blocks = covariance.reshape(k, 2, k, 2)
    every = np.arange(k)
    spread = blocks[every, :, every]
    squared, wide = mahalanobis(offsets, spread)
    missing: dict[int, float] = {}
    for row, one in zip(rows, wide.tolist(), strict=True):
        missing[row] = max(missing.get(row, -math.inf), threshold + one)
    best = _inside(list(range(k)), rows, columns, squared, wide + image_cost, threshold)
    least = _cost(best, rows, offsets, covariance, missing) + float(image_cost[best].sum())
    suggested = set[int]()
    for right in np.argsort(squared, kind="stable")[: TUNING.suggesting_pairs].tolist():
        if squared[right] > threshold:
            break
        if right in suggested:  # it would suggest the same
            continue
        gain = np.linalg.solve(spread[right], blocks[right].reshape(2, 2 * k)).T.reshape(k, 2, 2)
        left = offsets - gain @ offsets[right]
        rest = spread - gain @ blocks[right].transpose(1, 0, 2)
        open_ = [i for i in range(k) if rows[i] != rows[right] and columns[i] != columns[right]]
        near, log = mahalanobis(left[open_], rest[open_]) if open_ else (np.zeros(0), np.zeros(0))
        others = _inside(open_, rows, columns, near, log + image_cost[open_], threshold)
        found = sorted([right, *others])
        suggested.update(found)
        cost = _cost(found, rows, offsets, covariance, missing) + float(image_cost[found].sum())
        if cost < least:
            best, least = found, cost
    return best


def _inside(
    pairs: list[int],
    rows: list[int],
    columns: list[int],
    squared: Array,
    log_determinant: Array,
    threshold: float,
) -> list[int]:
    """Return the likeliest of some pairs, of those that are inside the gate."""
    inside = np.flatnonzero(squared <= threshold)
    of = [pairs[i] for i in inside.tolist()]
    chosen = likeliest(
        [rows[i] for i in of],
        [columns[i] for i in of],
        squared[inside].tolist(),
        log_determinant[inside].tolist(),
        threshold,
    )
    return [of[i] for i in chosen]


def _cost(
    chosen: list[int],
    rows: list[int],
    offsets: Array,
    covariance: Array,
    missing: dict[int, float],
) -> float:
    """Return minus twice the log likelihood of an assignment, up to a constant."""
    taken = {rows[i] for i in chosen}
    total = sum(one for row, one in missing.items() if row not in taken)
    if not chosen:
        return total
    place = np.array([[2 * i, 2 * i + 1] for i in chosen]).ravel()
    K = covariance[np.ix_(place, place)]
    lower = np.linalg.cholesky(K + TUNING.joint_rounding * K.diagonal().max() * np.eye(len(K)))
    white = np.linalg.solve(lower, offsets[chosen].ravel())
    return total + float(white @ white) + 2.0 * float(np.log(lower.diagonal()).sum())
