# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data association between two images in the image plane, where no pose is known.

The camera moves all points by one Gaussian motion (6,) (`image_motion`), and each point moves
independently with variance s² on each axis. An assignment of points to detections with stacked
residuals r and motion matrix C has the likelihood

    N(r; 0, diag(s²) + C P C') · detected^hits · (1 - detected)^misses · density^others

with unassigned detections at a Poisson density. The result are the marginals over all assignments;
where these are too many, over those suggested by any single pair, and over each exchange, change or
miss starting from the likeliest ones. So where points are so close, or images so far apart, that
several assignments explain them about equally well, the probability is shared among them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.image_motion import (
    Motion,
    by_motion,
    fitted,
    moved,
)
from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ImageLinksTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    gate_squared: float = 25.0
    """Squared Mahalanobis distance beyond which a pair is infeasible. Judged."""
    compared_assignments: int = 256
    """Up to this many assignments all are compared: any four points and detections, or eight well
    separated ones. Judged."""
    suggesting_pairs: int = 30
    """Otherwise the nearest pairs, up to this number, suggest an assignment each. Judged."""
    beside_assignments: int = 4
    """Number of the likeliest assignments whose variations are compared as well. Judged."""


TUNING = ImageLinksTuning()


_FORBIDDEN = 1e6


class Links(NamedTuple):
    """Probabilities that points are detections.

    Attributes:
        chances: (n, m) probability of each point to be each detection.
        motion: of the camera, given the likeliest assignment.
    """

    chances: Array
    motion: Motion


def links(
    points: Array,
    found: Array,
    variances: Array,
    motion: Motion,
    possible: NDArray[np.bool_],
    detected: Array,
    density: float,
) -> Links:
    """Associate points of one image with detections of the next one.

    Args:
        points: (n, 2) in the previous image.
        found: (m, 2) detections.
        variances: (n,) of a point's own motion and the noise of both boxes, each axis.
        motion: predicted motion of the image.
        possible: (n, m) whether a point can be a detection.
        detected: (n,) probability that a point exists and is detected.
        density: of detections that belong to no point, per unit of area.
    """
    n, m = possible.shape
    if not n or not m:
        return Links(np.zeros((n, m)), motion)
    law = _Law(points, found, variances, motion, detected, density)
    able = possible & (law.squared <= TUNING.gate_squared)
    every = _every(able)
    if every is None:
        every = _likely(law, able)
    scores = law.scores(every)
    weights = np.exp(scores - scores.max())
    weights /= weights.sum()
    chances = np.zeros((n, m + 1))
    for assignment, weight in zip(every, weights, strict=True):
        chances[np.arange(n), assignment] += weight
    return Links(chances[:, :m], law.posterior(every[int(scores.argmax())]))


def _every(able: NDArray[np.bool_]) -> Indices | None:
    """Return all assignments (k, n); None if they are more than `TUNING.compared_assignments`."""
    partial: list[list[int]] = [[]]
    for row in able:
        reach = np.flatnonzero(row).tolist()
        partial = [[*one, j] for one in partial for j in (-1, *reach) if j < 0 or j not in one]
        if len(partial) > TUNING.compared_assignments:
            return None
    return np.array(partial, np.intp)


def _likely(law: _Law, able: NDArray[np.bool_]) -> Indices:
    """Return assignments (k, n) that any pair suggests, and those beside the likeliest ones."""
    pairs = np.argwhere(able)
    nearest = np.argsort(law.squared[able], kind="stable")[: TUNING.suggesting_pairs]
    found = [law.completed(int(i), int(j), able) for i, j in pairs[nearest]]
    every = np.unique([np.full(len(able), -1, np.intp), *found], axis=0)
    scores = law.scores(every)
    best = every[np.argsort(-scores, kind="stable")[: TUNING.beside_assignments]]
    beside = [other for one in best for other in _others(one, able)]
    likely: Indices = np.unique([*every, *beside], axis=0)
    return likely


class _Law:
    """Likelihoods of assignments (n,): the detection of each point, -1 where it has none."""

    def __init__(
        self,
        points: Array,
        found: Array,
        variances: Array,
        motion: Motion,
        detected: Array,
        density: float,
    ) -> None:
        self._points, self._found, self._motion = points, found, motion
        self._inverse = np.linalg.inv(motion.covariance)
        self._by = by = by_motion(points)
        self._variances = variances
        self._residuals = found[None] - moved(points, motion)[:, None]
        spread = by @ motion.covariance @ by.swapaxes(1, 2)
        spread += variances[:, None, None] * np.eye(2)
        r = self._residuals
        self.squared: Array = np.einsum("nma,nab,nmb->nm", r, np.linalg.inv(spread), r)
        self._info = by.swapaxes(1, 2) @ by / variances[:, None, None]
        self._pull = np.einsum("nak,nma->nmk", by, r) / variances[:, None, None]
        # Of each pair by itself, against a point that is missed and a detection of no point:
        hit = np.log(detected / (1.0 - detected) / density / (2.0 * np.pi * variances))
        self._gains = hit[:, None] - 0.5 * (r**2).sum(axis=2) / variances[:, None]

    def scores(self, assignments: Array | Indices) -> Array:
        """Return the log likelihoods (k,) of assignments (k, n), up to a constant."""
        given = np.asarray(assignments)
        hits = given >= 0
        rows = np.arange(given.shape[1])
        chosen = np.where(hits, given, 0)
        gains = np.where(hits, self._gains[rows, chosen], 0.0).sum(axis=1)
        info = self._inverse + np.tensordot(hits.astype(float), self._info, axes=1)
        pull = np.where(hits[:, :, None], self._pull[rows, chosen], 0.0).sum(axis=1)
        common = np.einsum("ka,ka->k", pull, np.linalg.solve(info, pull[:, :, None])[:, :, 0])
        log_det = np.linalg.slogdet(info)[1] - np.linalg.slogdet(self._inverse)[1]
        scores: Array = gains + 0.5 * (common - log_det)
        return scores

    def posterior(self, assignment: Indices) -> Motion:
        """Return the camera's motion given an assignment."""
        rows = np.flatnonzero(assignment >= 0)
        after = self._found[assignment[rows]]
        return fitted(self._points[rows], after, self._variances[rows], self._motion)

    def completed(self, point: int, detection: int, able: NDArray[np.bool_]) -> Indices:
        """Return the likeliest assignment with one given pair, others by the motion it suggests."""
        n, m = able.shape
        alone = np.full(n, -1, np.intp)
        alone[point] = detection
        suggested = self.posterior(alone)
        left = self._residuals - (self._by @ (suggested.mean - self._motion.mean))[:, None]
        spread = self._by @ suggested.covariance @ self._by.swapaxes(1, 2)
        spread += self._variances[:, None, None] * np.eye(2)
        squared = np.einsum("nma,nab,nmb->nm", left, np.linalg.inv(spread), left)
        wider = np.log(np.linalg.det(spread)) - 2.0 * np.log(self._variances)
        own = (self._residuals**2).sum(axis=2) / self._variances[:, None]
        gains = self._gains + 0.5 * (own - squared - wider[:, None])
        cost = np.zeros((n, m + n))  # the last n: a point that is missed
        cost[:, :m] = np.where(able, -gains, _FORBIDDEN)
        cost[point, :] = _FORBIDDEN
        cost[point, detection] = -_FORBIDDEN
        _, columns = linear_sum_assignment(cost)
        return np.where(columns < m, columns, -1)


def _others(best: Indices, able: NDArray[np.bool_]) -> list[Indices]:
    """Return assignments that differ from one by an exchange, a change or a miss."""
    found = []
    free = [j for j in range(able.shape[1]) if j not in best]
    for i, j in enumerate(best.tolist()):
        reach = [-1, *(k for k in free if able[i, k])]
        found += [_with(best, {i: other}) for other in reach if other != j]
    for a, b in combinations(range(len(best)), 2):
        one, other = int(best[a]), int(best[b])
        if one >= 0 and able[b, one] and (other < 0 or able[a, other]):
            found.append(_with(best, {a: other, b: one}))
        elif other >= 0 and able[a, other] and one < 0:
            found.append(_with(best, {a: other, b: -1}))
    return found


def _with(assignment: Indices, changes: dict[int, int]) -> Indices:
    changed = assignment.copy()
    for point, detection in changes.items():
        changed[point] = detection
    return changed
