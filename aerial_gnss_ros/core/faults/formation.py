# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Re-identification of robots that are all displaced at once, by their relative positions.

Telemetry that jumps, or recovers from an error, displaces all robots by one rotation of the camera.
Absolute positions are useless then, relative ones are not. An assignment of robots to new tracks
with stacked offsets d of covariance S has the likelihood N(d; 0, S) without a displacement, and
N(d; 0, S + C C') if the camera seems rotated, higher or zoomed, where C is the derivative of
positions by these in units of their prior sigmas. Both are summed for each assignment, at even
prior odds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment

Array = NDArray[np.float64]
Pairs = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class FormationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    least_robots: int = 2
    """Least number of robots in a formation, which must also be more than half of those in view: a
    single one can be anywhere, and two of many match by chance. Judged."""
    turn_sigma_rad: float = math.radians(30.0)
    """Rotation that displaces them, one sigma, each axis, rad. Judged."""
    height_share: float = 0.3
    """Relative change of their distance, one sigma: a wrong height, or a zoom. Judged."""
    derivative_share: float = 0.15
    """Relative error of the linearisation, one sigma: rotations are not small. Judged."""
    widest_sigmas: float = 3.7
    """Sigmas of the normalised chi-square beyond which an assignment does not fit: one in
    10,000."""
    every_assignment_robots: int = 3
    """Up to this many robots all assignments are compared; beyond, those that two robots suggest.
    Judged."""
    seed_pairs: int = 6
    """Pairs of robots that suggest assignments, the farthest apart first. Judged."""


TUNING = FormationTuning()


@dataclass(frozen=True)
class Formation:
    """An assignment of robots to tracks by their relative positions.

    Attributes:
        pairs: indices of a robot and its track, as passed in.
        turn: (3,) rotation of the camera that displaces them, rad; 0 without one.
        spread: (3, 3) covariance of that, rad².
        moved: whether a turn is the likelier explanation.
    """

    pairs: Pairs
    turn: Array
    spread: Array
    moved: bool


def formation(
    offsets: Array,
    spread: Array,
    by_angles: Array,
    by_height: Array,
    possible: NDArray[np.bool_],
) -> Formation | None:
    """Return the assignment that relative positions determine, None if ambiguous.

    Args:
        offsets: (n, m, 2) from robots to tracks, m.
        spread: (n, m, 2, 2) their covariances without a displacement, m².
        by_angles: (n, 2, 3) derivative of the robots' positions by the platform's angles, m/rad.
        by_height: (n, 2) derivative by the logarithm of the height, m.
        possible: (n, m) whether a robot can be a track at all.
    """
    n, m = possible.shape
    if min(n, m) < TUNING.least_robots or 2 * min(n, m) <= n:
        return None
    common = np.concatenate(
        [TUNING.turn_sigma_rad * by_angles, TUNING.height_share * by_height[:, :, None]], axis=2
    )
    ranked: list[tuple[float, bool, Pairs]] = []
    for pairs in _assignments(offsets, spread, common, possible):
        stays = _score(offsets, spread, None, pairs)
        moves = _score(offsets, spread, common, pairs)
        fits = [one for one in (stays, moves) if one > -math.inf]
        if fits:
            ranked.append((float(np.logaddexp.reduce(fits)), moves > stays, pairs))
    if not ranked:
        return None
    ranked.sort(key=lambda one: -one[0])
    best = ranked[0]
    if len(ranked) > 1 and best[0] - ranked[1][0] < CLEAR_NATS:
        return None
    if not best[1]:
        return Formation(best[2], np.zeros(3), np.zeros((3, 3)), moved=False)
    turn, law = _explained(offsets, spread, TUNING.turn_sigma_rad * by_angles, best[2])
    return Formation(
        best[2], TUNING.turn_sigma_rad * turn, TUNING.turn_sigma_rad**2 * law, moved=True
    )


def _assignments(
    offsets: Array, spread: Array, common: Array, possible: NDArray[np.bool_]
) -> Iterator[Pairs]:
    """Yield assignments of as many robots as possible, each once."""
    n, m = possible.shape
    if max(n, m) <= TUNING.every_assignment_robots:
        wide = n <= m
        for order in permutations(range(max(n, m)), min(n, m)):
            pairs = tuple((k, j) if wide else (j, k) for k, j in enumerate(order))
            if all(possible[pair] for pair in pairs):
                yield tuple(sorted(pairs))
        return
    known: set[Pairs] = set()
    places = -offsets[:, 0]  # of the robots, from the first track on
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    seeds = np.column_stack(np.triu_indices(n, 1))
    seeds = seeds[np.argsort(-apart[seeds[:, 0], seeds[:, 1]], kind="stable")][: TUNING.seed_pairs]
    for first, second in seeds.tolist():
        for a, b in permutations(range(m), 2):
            if not (possible[first, a] and possible[second, b]):
                continue
            pairs = _completed(offsets, spread, common, possible, ((first, a), (second, b)))
            if pairs and pairs not in known:
                known.add(pairs)
                yield pairs


def _completed(
    offsets: Array, spread: Array, common: Array, possible: NDArray[np.bool_], seed: Pairs
) -> Pairs:
    """Return the assignment that completes two pairs; empty where these do not fit."""
    if _score(offsets, spread, common, seed) == -math.inf:
        return ()
    change, law = _explained(offsets, spread, common, seed)
    left = offsets - (common @ change)[:, None]
    around = _bent(offsets, spread) + (common @ law @ common.swapaxes(1, 2))[:, None]
    squared = np.einsum("nmi,nmij,nmj->nm", left, np.linalg.inv(around), left)
    cost = np.where(possible, squared + np.log(np.linalg.det(around)), 1e9)
    cost[[i for i, _ in seed], [j for _, j in seed]] = -1e9
    rows, columns = linear_sum_assignment(cost)
    pairs = tuple(sorted(zip(rows.tolist(), columns.tolist(), strict=True)))
    return pairs if all(possible[pair] for pair in pairs) else ()


def _bent(offsets: Array, spread: Array) -> Array:
    """Return covariances (n, m, 2, 2) widened by the error of the linearisation."""
    squared = TUNING.derivative_share**2 * np.sum(offsets**2, axis=-1)
    allowed: Array = spread + squared[..., None, None] * np.eye(2)
    return allowed


def _score(offsets: Array, spread: Array, common: Array | None, pairs: Pairs) -> float:
    """Return the log likelihood of an assignment, -inf if it does not fit at all.

    Args:
        offsets: (n, m, 2).
        spread: (n, m, 2, 2).
        common: (n, 2, q) derivative by what displaces all robots, in its own sigmas; None without a
            displacement.
        pairs: of robots and tracks.
    """
    if common is None:
        error, covariance = _stacked(offsets, spread, pairs)
    else:
        error, covariance = _stacked(offsets, _bent(offsets, spread), pairs)
        C = _rows(common, pairs)
        covariance = covariance + C @ C.T
    squared = float(error @ np.linalg.solve(covariance, error))
    freedom = len(error)
    # Wilson and Hilferty: the cube root of chi-square over its degrees of freedom is nearly normal.
    narrow = 2.0 / (9.0 * freedom)
    if (squared / freedom) ** (1.0 / 3.0) > 1.0 - narrow + TUNING.widest_sigmas * math.sqrt(narrow):
        return -math.inf
    return -0.5 * (squared + float(np.linalg.slogdet(covariance)[1]))


def _explained(offsets: Array, spread: Array, common: Array, pairs: Pairs) -> tuple[Array, Array]:
    """Return the displacement (q,) that fits an assignment, and its covariance (q, q)."""
    error, covariance = _stacked(offsets, _bent(offsets, spread), pairs)
    C = _rows(common, pairs)
    gain = np.linalg.solve(covariance + C @ C.T, C).T
    return gain @ error, np.eye(C.shape[1]) - gain @ C


def _stacked(offsets: Array, spread: Array, pairs: Pairs) -> tuple[Array, Array]:
    """Return offsets (2 k,) and their covariance (2 k, 2 k) of k pairs."""
    rows, columns = (np.array(side) for side in zip(*pairs, strict=True))
    k = len(pairs)
    covariance = np.zeros((k, 2, k, 2))
    covariance[np.arange(k), :, np.arange(k), :] = spread[rows, columns]
    return offsets[rows, columns].ravel(), covariance.reshape(2 * k, 2 * k)


def _rows(common: Array, pairs: Pairs) -> Array:
    """Return the derivatives (2 k, q) of k pairs."""
    found: Array = common[[row for row, _ in pairs]].reshape(2 * len(pairs), -1)
    return found
