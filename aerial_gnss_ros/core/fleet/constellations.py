# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which robots of one drone are which of the others': by all pairs together.

A drone's compass, height and receiver displace all of its robots in one way. Pairs are not judged
one by one: a hypothesis is a matching of some robots of the one with some of the other, and its
likelihood the joint normal density of all of its pairs' offsets, by the covariance of the whole
state. A robot that is matched with none lies anywhere nearby; if another camera should have seen it
and did not, that counts against it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ConstellationsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    nearby_m: float = 10.0
    """How far apart two different robots may lie, one sigma of each axis, m. Judged."""
    same_m: float = 0.1
    """Distance of two cameras' box centres on one robot, one sigma of each axis, m. Judged."""
    missed: float = 0.05
    """Probability that a camera does not show a robot in its view: detectors miss robots for
    seconds on end, so it does not fall with the number of images. Judged."""
    gate: float = 25.0
    """Greatest squared Mahalanobis distance of a single pair. A right one exceeds it 4 times in a
    million."""
    largest_count: int = 2000
    """At most so many matchings are weighed; the pairs that fit worst are left out. Judged."""


TUNING = ConstellationsTuning()


@dataclass(frozen=True)
class Matching:
    """A hypothesis.

    Attributes:
        pairs: of rows in the two sets of robots.
        probability: of it.
    """

    pairs: tuple[tuple[int, int], ...]
    probability: float


def matchings(
    offsets: Array,
    covariance: Array,
    possible: NDArray[np.bool_],
    first_in_view: Array,
    second_in_view: Array,
) -> list[Matching]:
    """Return the matchings with their probabilities, the likeliest first.

    Args:
        offsets: (m, n, 2) from m robots to n others, East, North, m.
        covariance: (m, n, 2, m, n, 2) of these, all together, m².
        possible: (m, n) whether a pair may be one robot.
        first_in_view: (m,) probability that it is in the view of another camera, which does not
            show it.
        second_in_view: (n,) likewise.
    """
    options = _options(offsets, covariance, possible)
    first_missed, second_missed = missed(first_in_view), missed(second_in_view)
    found: list[tuple[float, tuple[tuple[int, int], ...]]] = []
    for pairs in _choices(options, len(offsets)):
        fits = _log_ratio(offsets, covariance, pairs)
        alone_first = set(range(len(first_missed))) - {i for i, _ in pairs}
        alone_second = set(range(len(second_missed))) - {j for _, j in pairs}
        fits += sum(float(first_missed[i]) for i in alone_first)
        fits += sum(float(second_missed[j]) for j in alone_second)
        found.append((fits, pairs))
    best = max(fits for fits, _ in found)
    total = sum(math.exp(fits - best) for fits, _ in found)
    weighed = [Matching(pairs, math.exp(fits - best) / total) for fits, pairs in found]
    return sorted(weighed, key=lambda one: -one.probability)


def _options(offsets: Array, covariance: Array, possible: NDArray[np.bool_]) -> list[list[int]]:
    """Return for each of the m robots those of the others that fit, the best first."""
    m, n = possible.shape
    alone = np.full((m, n), np.inf)
    for i in range(m):
        for j in range(n):
            if possible[i, j]:
                spread = covariance[i, j, :, i, j] + TUNING.same_m**2 * np.eye(2)
                alone[i, j] = offsets[i, j] @ np.linalg.solve(spread, offsets[i, j])
    most = n
    while True:
        kept = [
            [j for j in np.argsort(alone[i]).tolist()[:most] if alone[i, j] <= TUNING.gate]
            for i in range(m)
        ]
        if most <= 1 or math.prod(1 + len(one) for one in kept) <= TUNING.largest_count:
            return kept
        most -= 1


def _choices(options: list[list[int]], m: int) -> list[tuple[tuple[int, int], ...]]:
    """Return all injective matchings by these options, at most `largest_count`."""
    found: list[tuple[tuple[int, int], ...]] = [()]
    for i in range(m):
        more = [
            (*pairs, (i, j))
            for pairs in found
            for j in options[i]
            if all(j != other for _, other in pairs)
        ]
        if len(found) + len(more) > TUNING.largest_count:
            break
        found += more
    return found


def missed(in_view: Array) -> Array:
    """Return the log probabilities (m,) that a camera does not show robots, nats.

    Args:
        in_view: (m,) probability that each is in its view.
    """
    found: Array = np.log1p(-(1.0 - TUNING.missed) * in_view)
    return found


def _log_ratio(offsets: Array, covariance: Array, pairs: tuple[tuple[int, int], ...]) -> float:
    """Return the log likelihood ratio of pairs being one robot each to none being so."""
    if not pairs:
        return 0.0
    first, second = (np.array(side) for side in zip(*pairs, strict=True))
    apart = offsets[first, second].ravel()
    spread = covariance[first, second][:, :, first, second].reshape(len(apart), -1)
    size = len(apart)
    log_same = log_normal(apart, spread + TUNING.same_m**2 * np.eye(size))
    return log_same - log_normal(apart, spread + TUNING.nearby_m**2 * np.eye(size))


def log_normal(offset: Array, spread: Array) -> float:
    """Return the log density of an offset (d,) with mean 0 and covariance (d, d)."""
    _, log_determinant = np.linalg.slogdet(2.0 * math.pi * spread)
    return -0.5 * (float(log_determinant) + float(offset @ np.linalg.solve(spread, offset)))
