# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Innovations of nearby pairs of robots and detections, with covariances."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InnovationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    few_pairs: int = 16
    """Greatest number of pairs that are compared without a preselection by distance. Judged."""


TUNING = InnovationTuning()


@dataclass(frozen=True)
class PairInnovations:
    """k pairs of robots and detections, by row, then by column.

    Attributes:
        rows: (k,) robots.
        columns: (k,) detections.
        offsets: (k, 2) from robot to detection, East, North, m.
        spread: (k, 2, 2) their covariances, m².
    """

    rows: Indices
    columns: Indices
    offsets: Array
    spread: Array

    def of(self, chosen: list[int]) -> PairInnovations:
        """Return some of the pairs."""
        rows, columns = self.rows[chosen], self.columns[chosen]
        return PairInnovations(rows, columns, self.offsets[chosen], self.spread[chosen])

    @classmethod
    def of_groups(cls, parts: list[PairInnovations]) -> PairInnovations:
        """Return the pairs of several groups together."""
        rows = np.concatenate([part.rows for part in parts])
        columns = np.concatenate([part.columns for part in parts])
        order = np.lexsort((columns, rows))
        offsets = np.concatenate([part.offsets for part in parts])
        spread = np.concatenate([part.spread for part in parts])
        return cls(rows[order], columns[order], offsets[order], spread[order])


@lru_cache(maxsize=64)
def _every(n: int, m: int) -> tuple[Indices, Indices]:
    """Return slots and columns (n m,) of all pairs of n robots and m detections; read-only."""
    slots, columns = np.divmod(np.arange(n * m), m)
    slots.flags.writeable = columns.flags.writeable = False
    return slots, columns


def pair_innovations(
    group: JointState, places: Array, by_errors: Array, white: Array, scale: float, floor: float
) -> PairInnovations:
    """Return the innovations of detections with a group's robots.

    A pair's squared Mahalanobis distance is at least its squared distance over the covariance's
    trace, which preselects pairs.

    Args:
        group: n robots, one at least.
        places: (m, 2) positions of the detections by the group's platform errors, m.
        by_errors: (m, 2, 9) derivatives of these by the platform's errors.
        white: (m, 2, 2) their white covariance, m².
        scale: of the trace, and
        floor: m², of the squared distance up to which a pair is returned.
    """
    n, m = len(group.rows), len(places)
    with_platform = by_errors @ group.covariance[:COUNT, :COUNT]
    own = with_platform @ by_errors.swapaxes(1, 2) + white
    robots, blocks, with_robots = group.positions()
    # Of each robot with each detection: by both axes of each.
    shared = with_robots.reshape(-1, COUNT) @ by_errors.reshape(-1, COUNT).T
    shared = shared.reshape(n, 2, m, 2)
    if n * m <= TUNING.few_pairs:
        slots, columns = _every(n, m)
    else:
        apart = robots[:, 0, None] - places[:, 0], robots[:, 1, None] - places[:, 1]
        trace = own[:, 0, 0] + own[:, 1, 1] - 2.0 * (shared[:, 0, :, 0] + shared[:, 1, :, 1])
        trace += (blocks[:, 0, 0] + blocks[:, 1, 1])[:, None]
        near = apart[0] ** 2 + apart[1] ** 2 <= scale * trace + floor
        slots, columns = np.nonzero(near)
    common = shared[slots, :, columns]
    spread = blocks[slots] + own[columns] - common - common.swapaxes(1, 2)
    return PairInnovations(group.rows[slots], columns, places[columns] - robots[slots], spread)


def joint_covariance(
    group: JointState, slots: Indices, by_errors: Array, white: Array, own: Array
) -> Array:
    """Return the covariance (2 k, 2 k) of the innovations of k pairs together, m².

    What moves all boxes of the image alike is in the covariances between pairs: the platform's
    errors, and of the white noise what is not a box's own.

    Args:
        group: the robots.
        slots: (k,) indices of the pairs' robots.
        by_errors: (k, 2, 9) derivatives of the boxes' positions by the platform's errors.
        white: (k, 2, 2) white covariance of these, m².
        own: (k, 2, 2) part of it that is the boxes' own, m².
    """
    P, k = group.covariance, len(slots)
    place = (COUNT + 4 * slots[:, None] + np.arange(2)).ravel()
    moved = by_errors.reshape(2 * k, COUNT)
    with_robots = moved @ P[:COUNT, place]
    found = moved @ P[:COUNT, :COUNT] @ moved.T - with_robots - with_robots.T
    found += P[np.ix_(place, place)]
    common = white - own
    values, vectors = np.linalg.eigh(common)
    root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :] @ vectors.swapaxes(1, 2)
    alike = root.reshape(2 * k, 2)
    found += alike @ alike.T
    blocks, every = found.reshape(k, 2, k, 2), np.arange(k)
    blocks[every, :, every] += white - root @ root
    return found


def misfit(pairs: PairInnovations, robots: list[int], threshold: float) -> float:
    """Return half the summed squared Mahalanobis distances of robots from their boxes, nats.

    Each box belongs to one robot at most, inside its gate.

    Args:
        pairs: of robots and detections.
        robots: rows of the expected robots.
        threshold: squared distance at the edge of a gate.
    """
    squared, _ = mahalanobis(pairs.offsets, pairs.spread)
    left, taken, total = set(robots), set[int](), 0.0
    for k in np.argsort(squared, kind="stable").tolist():
        row, column = int(pairs.rows[k]), int(pairs.columns[k])
        if squared[k] <= threshold and row in left and column not in taken:
            left.remove(row)
            taken.add(column)
            total += float(squared[k])
    return 0.5 * (total + threshold * len(left))
