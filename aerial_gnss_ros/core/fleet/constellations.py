# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which robots of one drone are which of the others': by all pairs together.

A drone's compass, height and receiver displace all of its robots in one way. Pairs are not judged
one by one: a hypothesis is a matching of some robots of the one with some of the other, and its
likelihood the joint normal density of all of its pairs' offsets, by the covariance of the whole
state. A robot that is matched with none lies anywhere among the others, by their density; if
another camera should have seen it and did not, that counts against it. How many robots both drones
see is unknown, any number as likely as another: four of thirty may well agree by chance, while of
thirty that agree each makes the others likelier.

Hypotheses grow by one robot at a time, all of them at once, those of the largest constellation
first: two or three right pairs fix the errors that all have in common, after which hardly any
other pair fits. Each keeps the inverse root of its pairs' covariance, so that one more pair costs a
product and no decomposition; those far behind are given up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_LEAST = 1e-12
"""Least variance of what another pair of the same robot leaves, m²."""


@dataclass(frozen=True)
class ConstellationsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    nearby_m: float = 10.0
    """How far around a robot another one may lie, one sigma of each axis, m: thirty robots in a
    small place agree with others by chance, three hardly do. Judged."""
    same_m: float = 0.1
    """Distance of two cameras' box centres on one robot, one sigma of each axis, m. Judged."""
    missed: float = 0.05
    """Probability that a camera does not show a robot in its view: detectors miss robots for
    seconds on end, so it does not fall with the number of images. Judged."""
    gate: float = 25.0
    """Greatest squared Mahalanobis distance of a pair by itself, and given the others of its
    matching. A right one exceeds it 4 times in a million."""
    behind: float = 10.0
    """Log likelihood behind the best matching from which one is given up, nats: 1 in 20000."""
    largest_count: int = 200
    """At most so many matchings are weighed at once. Judged: twice as many change no decision."""
    largest_pairs: int = 400
    """At most so many pairs are weighed: the rest of the first drone's robots wait until these are
    decided. Judged: 20 ms."""


TUNING = ConstellationsTuning()


@dataclass(frozen=True)
class Matching:
    """A hypothesis.

    Attributes:
        pairs: of rows in the two sets of robots.
        probability: of it.
        gain: its log likelihood ratio to no pair at all, nats.
    """

    pairs: tuple[tuple[int, int], ...]
    probability: float
    gain: float = 0.0


@dataclass(frozen=True)
class Candidates:
    """Pairs of robots that may be one, ordered by the first.

    Attributes:
        count: m, the number of robots in the first set.
        first: (k,) rows in the first set.
        second: (k,) rows in the second set.
        offsets: (k, 2) from the one to the other, East, North, m.
        covariance: (k, 2, k, 2) of these, all together, m².
        density: (k,) of the second set's robots around each, 1/m².
        whole: whether no pair was left out.
    """

    count: int
    first: Indices
    second: Indices
    offsets: Array
    covariance: Array
    density: Array
    whole: bool

    @staticmethod
    def of(places: Array, covariance: Array, possible: NDArray[np.bool_]) -> Candidates:
        """Return the pairs that fit, each by itself.

        Args:
            places: (m + n, 2) of m robots and n others, East, North, m.
            covariance: (m + n, 2, m + n, 2) of them, m².
            possible: (m, n) whether a pair may be one robot.
        """
        m = len(possible)
        first, second = np.nonzero(possible)
        own = np.einsum("iaib->iab", covariance)
        between = covariance[first, :, m + second]
        spread = own[first] + own[m + second] - between - between.swapaxes(1, 2)
        offsets = places[m + second] - places[first]
        squared, _ = _density_of(offsets, spread + TUNING.same_m**2 * np.eye(2))
        near = squared <= TUNING.gate
        first, second, offsets = first[near], second[near], offsets[near]
        fewest = np.argsort(np.bincount(first, minlength=m), kind="stable")
        kept = fewest[np.cumsum(np.bincount(first, minlength=m)[fewest]) <= TUNING.largest_pairs]
        some = np.isin(first, kept)
        whole = bool(some.all())
        first, second, offsets = first[some], second[some], offsets[some]
        i, j = first, m + second
        # Robot by robot, since a copy of whole rows costs less than scattered blocks.
        rows = covariance[j] - covariance[i]
        wide = rows[:, :, j] - rows[:, :, i]
        for axis in (0, 1):
            k = np.arange(len(i))
            wide[k, axis, k, axis] += TUNING.same_m**2
        density = _density(places[m:])[second]
        return Candidates(m, first, second, offsets, wide, density, whole)

    def __len__(self) -> int:
        return len(self.first)


def matchings(
    candidates: Candidates, first_in_view: Array, second_in_view: Array
) -> list[Matching]:
    """Return the matchings with their probabilities, the likeliest first.

    Args:
        candidates: pairs that may be one robot.
        first_in_view: (m,) probability that it is in the view of another camera, which does not
            show it.
        second_in_view: (n,) likewise.
    """
    if not len(candidates):
        return [Matching((), 1.0)]
    extra = -missed(first_in_view)[candidates.first]
    extra -= np.log(2.0 * math.pi * candidates.density)
    if candidates.whole:  # else a robot without a pair may belong to one that waits
        extra -= missed(second_in_view)[candidates.second]
    found = _Hypotheses.none(candidates, extra)
    for robot in _order(candidates, extra):
        found = found.extended(np.flatnonzero(candidates.first == robot))
    return found.weighed()


def missed(in_view: Array) -> Array:
    """Return the log probabilities (m,) that a camera does not show robots, nats.

    Args:
        in_view: (m,) probability that each is in its view.
    """
    found: Array = np.log1p(-(1.0 - TUNING.missed) * in_view)
    return found


@dataclass(frozen=True)
class _Hypotheses:
    """Matchings (b,) of up to p pairs each, of those robots that have been considered.

    Attributes:
        candidates: all pairs.
        extra: (k,) gain of each, besides that its places agree: neither camera misses it, and no
            other robot needs to lie there, nats.
        considered: number of the first set's robots that they are of.
        chosen: (b, p) pairs of each; -1 beyond their number.
        count: (b,) this number.
        inverse: (b, 2 p, 2 p) inverse lower roots of the covariances of their offsets; the unit
            matrix beyond.
        white: (b, 2 p) these offsets in units of the roots; 0 beyond.
        gain: (b,) log likelihood ratio to no pair at all, nats, plus log(considered!).
    """

    candidates: Candidates
    extra: Array
    considered: int
    chosen: Indices
    count: Indices
    inverse: Array
    white: Array
    gain: Array

    @staticmethod
    def none(candidates: Candidates, extra: Array) -> _Hypotheses:
        """Return the matching without pairs."""
        return _Hypotheses(
            candidates, extra, 0, np.zeros((1, 0), np.intp), np.zeros(1, np.intp),
            np.zeros((1, 0, 0)), np.zeros((1, 0)), np.zeros(1),
        )  # fmt: skip

    def extended(self, pairs: Indices) -> _Hypotheses:
        """Return each without a further robot, and with each of its pairs (q,) that fits."""
        by_old, roots, white = self._given_chosen(pairs)
        fits = np.square(white).sum(axis=2) <= TUNING.gate
        second = self.candidates.second
        used = np.where(self.chosen < 0, -1, second[self.chosen])
        fits &= ~(used[:, :, None] == second[pairs]).any(axis=1)
        more = _log_density(white, roots) + self.extra[pairs]
        # Laplace's rule of succession, but for what is common to all.
        alone = self.gain + np.log(self.considered - self.count + 1.0)
        more += (self.gain + np.log(self.count + 1.0))[:, None]
        gains = np.concatenate([alone[:, None], more], axis=1)
        gains[:, 1:][~fits] = -np.inf
        flat, best = gains.ravel(), float(gains.max())
        order = np.argsort(-flat, kind="stable")[: TUNING.largest_count]
        order = order[flat[order] >= best - TUNING.behind]
        parents, options = np.divmod(order, len(pairs) + 1)
        return self._with(parents, options - 1, pairs, (by_old, roots, white), flat[order])

    def _given_chosen(self, pairs: Indices) -> tuple[Array, Array, Array]:
        """Return what pairs (q,) are given those of each hypothesis.

        Returns:
            Their offsets' covariance with the whitened ones (b, 2 p, q, 2), the inverse lower roots
            of what is left of their own (b, q, 2, 2), and the residuals in units of these
            (b, q, 2).
        """
        C, (b, p), q = self.candidates.covariance, self.chosen.shape, len(pairs)
        between = C[:, :, pairs][self.chosen] * (self.chosen >= 0)[:, :, None, None, None]
        by_old = (self.inverse @ between.reshape(b, 2 * p, 2 * q)).reshape(b, 2 * p, q, 2)
        told = by_old.transpose(0, 2, 3, 1)  # (b, q, 2, 2 p)
        left = np.einsum("qaqc->qac", C[pairs][:, :, pairs]) - told @ told.swapaxes(2, 3)
        rest = self.candidates.offsets[pairs] - (told @ self.white[:, None, :, None])[..., 0]
        white, roots = _whitened(rest, left)
        return by_old, roots, white

    def _with(
        self, parents: Indices, options: Indices, pairs: Indices, given: tuple[Array, Array, Array],
        gain: Array,
    ) -> _Hypotheses:  # fmt: skip
        """Return some hypotheses, each with one of some pairs or, at -1, without."""
        by_old, roots, white = given
        count, p = self.count[parents], self.chosen.shape[1]
        longer = np.flatnonzero(options >= 0)
        wide = max(p, int(count[longer].max(initial=-1)) + 1)
        chosen = np.full((len(parents), wide), -1, np.intp)
        chosen[:, :p] = self.chosen[parents]
        inverse = np.zeros((len(parents), 2 * wide, 2 * wide))
        inverse[:, : 2 * p, : 2 * p] = self.inverse[parents]
        for k in range(2 * p, 2 * wide):
            inverse[:, k, k] = 1.0
        whitened = np.zeros((len(parents), 2 * wide))
        whitened[:, : 2 * p] = self.white[parents]
        old, option, slot = parents[longer], options[longer], count[longer]
        chosen[longer, slot] = pairs[option]
        root = roots[old, option]
        by_first = by_old[old, :, option].swapaxes(1, 2) @ self.inverse[old]
        for axis in (0, 1):
            row = 2 * slot + axis
            inverse[longer, row] = 0.0
            inverse[longer, row, : 2 * p] = -(root[:, None, axis] @ by_first)[:, 0]
            inverse[longer, row, 2 * slot] = root[:, axis, 0]
            inverse[longer, row, 2 * slot + 1] = root[:, axis, 1]
            whitened[longer, row] = white[old, option, axis]
        count = count + (options >= 0)
        return _Hypotheses(
            self.candidates, self.extra, self.considered + 1, chosen, count, inverse, whitened, gain
        )

    def weighed(self) -> list[Matching]:
        """Return them with their probabilities, the likeliest first."""
        weights = np.exp(self.gain - self.gain.max())
        first, second = self.candidates.first, self.candidates.second
        found = [
            Matching(
                tuple(sorted((int(first[k]), int(second[k])) for k in chosen if k >= 0)),
                float(weight),
                float(gain) - math.lgamma(self.considered + 1),
            )
            for chosen, weight, gain in zip(
                self.chosen, weights / weights.sum(), self.gain, strict=True
            )
        ]
        return sorted(found, key=lambda one: -one.probability)


def _order(candidates: Candidates, extra: Array) -> list[int]:
    """Return the first set's robots, those of the largest constellation first.

    Each pair in turn is taken to be one robot: how well do the best pairs of all others then fit?
    """
    robots, starts = np.unique(candidates.first, return_index=True)
    if len(robots) < 2:
        return [int(one) for one in robots]
    C, first, second = candidates.covariance, candidates.first, candidates.second
    k, own = len(first), np.einsum("kakb->kab", C)
    alone, root = _whitened(candidates.offsets, own)
    told = (root @ C.reshape(k, 2, 2 * k)).reshape(k, 2, k, 2)  # of each with the whitened one
    rest = candidates.offsets - told[:, 0] * alone[:, None, :1] - told[:, 1] * alone[:, None, 1:]
    left = own - np.einsum("sacx,sacy->scxy", told, told)
    squared, gains = _density_of(rest, left)
    gains += extra
    taken = (first[:, None] == first) | (second[:, None] == second)
    gains[taken | (squared > TUNING.gate)] = 0.0
    best = np.maximum(np.maximum.reduceat(gains, starts, axis=1), 0.0)
    potential = best.sum(axis=1) + _density_of(candidates.offsets, own)[1] + extra
    each = np.maximum.reduceat(potential, starts)
    return [int(one) for one in robots[np.argsort(-each, kind="stable")]]


def _density_of(offsets: Array, spread: Array) -> tuple[Array, Array]:
    """Return squared Mahalanobis distances of offsets, and log densities but for log(2 pi), nats.

    Args:
        offsets: (..., 2), m.
        spread: (..., 2, 2) covariances, m².
    """
    x, y = offsets[..., 0], offsets[..., 1]
    a, b, d = spread[..., 0, 0], spread[..., 1, 0], spread[..., 1, 1]
    determinant = np.maximum(a * d - b * b, _LEAST**2)
    squared = (d * x * x - 2.0 * b * x * y + a * y * y) / determinant
    return squared, -0.5 * (squared + np.log(determinant))


def _log_density(white: Array, roots: Array) -> Array:
    """Return the log densities of offsets (..., 2), but for log(2 pi), nats.

    Args:
        white: (..., 2) offsets in units of their roots.
        roots: (..., 2, 2) inverse lower roots of their covariances.
    """
    found: Array = np.log(roots[..., 0, 0] * roots[..., 1, 1])
    found -= 0.5 * np.square(white).sum(axis=-1)
    return found


def _density(places: Array) -> Array:
    """Return the density of robots (n,) around each of them, 1/m²: each lies about its place."""
    apart = np.square(places[:, None] - places).sum(axis=2) / TUNING.nearby_m**2
    found: Array = np.exp(-0.5 * apart).sum(axis=1) / (2.0 * math.pi * TUNING.nearby_m**2)
    return found


def _whitened(offsets: Array, spread: Array) -> tuple[Array, Array]:
    """Return offsets (..., 2) in units of the lower roots of their covariances, and their inverses.

    Args:
        offsets: (..., 2), m.
        spread: (..., 2, 2) covariances, m².
    """
    a = np.sqrt(np.maximum(spread[..., 0, 0], _LEAST))
    b = spread[..., 1, 0] / a
    d = np.sqrt(np.maximum(spread[..., 1, 1] - b * b, _LEAST))
    inverse = np.zeros(spread.shape)
    inverse[..., 0, 0], inverse[..., 1, 1] = 1.0 / a, 1.0 / d
    inverse[..., 1, 0] = -b / (a * d)
    return (inverse @ offsets[..., None])[..., 0], inverse
