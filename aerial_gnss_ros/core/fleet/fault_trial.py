# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which drone is wrong when drones show robots in different places.

The last image of each drone, by itself, with the errors that each drone states: under which fault
do the constellations agree? Nothing of the filter enters, since what it believes may come from the
faulty drone. With two drones, a displacement of all robots is as likely the one's receiver as the
other's; a turned compass rotates them about its own drone, so that precise receivers tell whose it
is. With three drones, only the fault of the wrong one makes all agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.constellations import TUNING as CONSTELLATIONS
from aerial_gnss_ros.core.fleet.constellations import log_normal, missed
from aerial_gnss_ros.core.fleet.fault import FAULTS, Suspicion
from aerial_gnss_ros.core.fleet.shared_state import joint_prior
from aerial_gnss_ros.core.fleet.snapshot import Placed, Snapshot
from aerial_gnss_ros.core.models.platform_model import COUNT, PLATFORM

Array = NDArray[np.float64]
Pairs = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class FaultTrialTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    steps: int = 3
    """Linearisations of a matching. Judged: from 20 deg off the third changes nothing."""
    compass_step: float = math.radians(20.0)
    """Steps of a faulty compass at which matchings are sought, rad: less than what is linear.
    Judged."""


TUNING = FaultTrialTuning()
HEADING = PLATFORM.index("heading")


@dataclass(frozen=True)
class Agreed:
    """How two images agree under a hypothesis.

    Attributes:
        log_likelihood: of the best matching, with what the unmatched robots say, nats.
        pairs: of it, rows in both images.
        errors: (14,) the drones' errors by it.
    """

    log_likelihood: float
    pairs: Pairs
    errors: Array


@dataclass(frozen=True)
class Trial:
    """A fault under which images agree.

    Attributes:
        suspicion: the fault with its likelihood ratio to none.
        errors: (7,) the drone's errors by it.
        matched: its robots with those of other drones: its own label, number and label of the
            other.
    """

    suspicion: Suspicion
    errors: Array
    matched: tuple[tuple[str, int, str], ...]


def trials(
    snapshots: dict[int, Snapshot], stationary: list[Array], share: float, speed: float
) -> list[Trial]:
    """Return how well each fault of each drone explains what all show.

    Args:
        snapshots: by number of the drone.
        stationary: (7, 7) covariance of each drone's errors as it states them.
        share: of the receivers' variance that is common.
        speed: one sigma of a robot's velocity, each axis, m/s.
    """
    stated: dict[tuple[int, int], Agreed] = {}
    numbers = sorted(snapshots)

    def prior(one: int, other: int, wrong: int | None, more: Array) -> Array:
        found = joint_prior([stationary[one], stationary[other]], share)
        place = COUNT if wrong == other else 0
        found[place : place + COUNT, place : place + COUNT] += np.diag(more)
        return found

    for one in numbers:
        for other in numbers:
            if one < other:
                pair = _PairOfImages(snapshots[one], snapshots[other], speed)
                stated[one, other] = pair.agreed(prior(one, other, None, np.zeros(COUNT)))
    found = []
    for wrong in numbers:
        for fault in FAULTS:
            ratio, matched, errors = 0.0, list[tuple[str, int, str]](), list[Array]()
            for other in (each for each in numbers if each != wrong):
                # The wrong drone comes first.
                pair = _PairOfImages(snapshots[wrong], snapshots[other], speed)
                law = prior(wrong, other, wrong, fault.variances)
                starts = _starts(fault.sensor)
                agreed = max((pair.agreed(law, start) for start in starts), key=_by_likelihood)
                by_none = stated[min(wrong, other), max(wrong, other)]
                ratio += agreed.log_likelihood - by_none.log_likelihood
                own, others = snapshots[wrong].labels, snapshots[other].labels
                matched += [(own[i], other, others[j]) for i, j in agreed.pairs]
                errors.append(agreed.errors[:COUNT])
            mean = np.mean(errors, axis=0)
            found.append(Trial(Suspicion(wrong, fault, ratio), mean, tuple(matched)))
    return found


def _by_likelihood(one: Agreed) -> float:
    return one.log_likelihood


def _starts(sensor: str) -> list[Array]:
    """Return errors (14,) at which matchings are sought: rotations are far from linear."""
    angles = [0.0]
    if sensor == "compass":
        angles = np.arange(-math.pi, math.pi - 1e-9, TUNING.compass_step).tolist()
    found = []
    for angle in angles:
        start = np.zeros(2 * COUNT)
        start[HEADING] = angle
        found.append(start)
    return found


class _PairOfImages:
    """Robots of two images.

    Args:
        first: an image.
        second: of another drone.
        speed: one sigma of a robot's velocity, each axis, m/s.
    """

    def __init__(self, first: Snapshot, second: Snapshot, speed: float) -> None:
        self._both = first, second
        self._possible = np.array([[a == b for b in second.class_ids] for a in first.class_ids])
        between = speed * 1e-9 * abs(first.scene_ns - second.scene_ns)
        self._moved = between**2 * np.eye(2)

    def agreed(self, prior: Array, start: Array | None = None) -> Agreed:
        """Return how they agree if the drones' errors have a prior (14, 14)."""
        at = np.zeros(2 * COUNT) if start is None else start
        found = Agreed(-math.inf, (), at)
        for _ in range(TUNING.steps):
            placed = self._both[0].placed(at[:COUNT]), self._both[1].placed(at[COUNT:])
            if not all(np.isfinite(one.places).all() for one in placed):
                break
            found = self._linear(placed, at, prior)
            if not found.pairs:
                break
            at = found.errors
        return found

    def _linear(self, placed: tuple[Placed, Placed], at: Array, prior: Array) -> Agreed:
        """Return how they agree by places and derivatives at some errors (14,)."""
        (first, second), m, n = placed, len(placed[0].places), len(placed[1].places)
        by_errors = np.zeros((m, n, 2, 2 * COUNT))
        by_errors[..., :COUNT] = -first.by_errors[:, None]
        by_errors[..., COUNT:] = second.by_errors[None]
        offsets = second.places[None] - first.places[:, None] - by_errors @ at
        flat = by_errors.reshape(-1, 2 * COUNT)
        covariance = (flat @ prior @ flat.T).reshape(m, n, 2, m, n, 2)
        for i in range(m):
            covariance[i, :, :, i] += (first.white[i] + self._moved)[None, :, None]
        for j in range(n):
            covariance[:, j, :, :, j] += second.white[j][None, :, None]
        best = max(
            ((self._log_likelihood(offsets, covariance, pairs, placed, at), pairs)
             for pairs in _matchings(offsets, covariance, self._possible)),
        )  # fmt: skip
        return Agreed(*best, _posterior(offsets, covariance, by_errors, prior, best[1]))

    def _log_likelihood(
        self, offsets: Array, covariance: Array, pairs: Pairs, placed: tuple[Placed, Placed],
        at: Array,
    ) -> float:  # fmt: skip
        """Return the log likelihood of a matching against robots anywhere nearby, nats.

        Unlike those of one hypothesis, likelihoods of different ones need a common reference:
        unmatched robots have a uniform density.
        """
        apart, spread = _of_pairs(offsets, covariance, pairs)
        found = log_normal(apart, spread) if pairs else 0.0
        found += len(pairs) * math.log(2.0 * math.pi * CONSTELLATIONS.nearby_m**2)
        for side in (0, 1):
            other = self._both[1 - side].drone
            errors = at[COUNT * (1 - side) : COUNT * (2 - side)]
            matched = {pair[side] for pair in pairs}
            for k, place in enumerate(placed[side].places):
                if k not in matched:
                    spread = placed[side].white[k]
                    found += float(missed(np.array([other.shows(errors, place, spread)]))[0])
        return found


def _matchings(offsets: Array, covariance: Array, possible: NDArray[np.bool_]) -> set[Pairs]:
    """Return matchings that some one pair implies, and that without pairs.

    If one pair is one robot, that fixes most of what the drones' errors do to all others.
    """
    m, n = possible.shape
    flat, blocks = offsets.reshape(-1, 2), covariance.reshape(m * n, 2, m * n, 2)
    same, found = CONSTELLATIONS.same_m**2 * np.eye(2), set[Pairs]([()])
    diagonal = np.einsum("kakb->kab", blocks)
    for k in np.flatnonzero(possible.ravel()).tolist():
        spread = blocks[k, :, k] + same
        if flat[k] @ np.linalg.solve(spread, flat[k]) > CONSTELLATIONS.gate:
            continue
        gain = blocks[:, :, k] @ np.linalg.inv(spread)
        rest = flat - gain @ flat[k]
        left = diagonal - gain @ blocks[k].transpose(1, 0, 2) + same
        squared = (rest[:, None] @ np.linalg.solve(left, rest[..., None]))[:, 0, 0]
        squared[k] = 0.0
        taken: list[tuple[int, int]] = []
        for other in np.argsort(squared).tolist():
            i, j = divmod(other, n)
            free = all(i != a and j != b for a, b in taken)
            if free and possible[i, j] and squared[other] <= CONSTELLATIONS.gate:
                taken.append((i, j))
        found.add(tuple(sorted(taken)))
    return found


def _posterior(
    offsets: Array, covariance: Array, by_errors: Array, prior: Array, pairs: Pairs
) -> Array:
    """Return the errors (14,) by which pairs come closest."""
    if not pairs:
        return np.zeros(2 * COUNT)
    first, second = np.array(pairs).T
    H = by_errors[first, second].reshape(-1, 2 * COUNT)
    apart, spread = _of_pairs(offsets, covariance, pairs)
    found: Array = -prior @ H.T @ np.linalg.solve(spread, apart)
    return found


def _of_pairs(offsets: Array, covariance: Array, pairs: Pairs) -> tuple[Array, Array]:
    """Return the offsets (2 k,) of k pairs, and their covariance with that of box centres."""
    first, second = np.array(pairs, np.intp).reshape(-1, 2).T
    apart = offsets[first, second].ravel()
    spread = covariance[first, second][:, :, first, second].reshape(len(apart), len(apart))
    return apart, spread + CONSTELLATIONS.same_m**2 * np.eye(len(apart))
