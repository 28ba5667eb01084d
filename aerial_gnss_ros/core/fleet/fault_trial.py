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

from aerial_gnss_ros.core.fleet.constellations import Candidates, matchings, missed
from aerial_gnss_ros.core.fleet.fault import FAULTS, Fault, Suspicion
from aerial_gnss_ros.core.fleet.receivers import joint_prior
from aerial_gnss_ros.core.fleet.snapshot import Placed, Snapshot
from aerial_gnss_ros.core.models.platform_model import COUNT, HEADING

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
    followed: int = 3
    """Number of these that are linearised again: those that fit best. Judged."""
    robots: tuple[int, int] = 6, 15
    """Greatest number of robots of the first and of the second image, those in the middle: a few
    tell a fault as well as all. Judged: 3 ms for a matching of these."""


TUNING = FaultTrialTuning()


@dataclass(frozen=True)
class Agreed:
    """How two images agree under a hypothesis.

    Attributes:
        log_likelihood: of the best matching, with what the unmatched robots say, nats.
        pairs: of it, rows in both images.
        errors: (18,) the drones' errors by it.
    """

    log_likelihood: float
    pairs: Pairs
    errors: Array


@dataclass(frozen=True)
class Trial:
    """A fault under which images agree.

    Attributes:
        suspicion: the fault with its likelihood ratio to none.
        errors: (9,) the drone's errors by it.
        matched: its robots with those of other drones: its own label, number and label of the
            other.
    """

    suspicion: Suspicion
    errors: Array
    matched: tuple[tuple[str, int, str], ...]


def trials(snapshots: dict[int, Snapshot], stationary: list[Array], speed: float) -> list[Trial]:
    """Return how well each fault of each drone explains what all show.

    Receivers are taken to have nothing in common: what they truly have is not known, and the less
    it is, the more can be explained without a fault.

    Args:
        snapshots: by number of the drone.
        stationary: (9, 9) covariance of each drone's errors as it states them.
        speed: one sigma of a robot's velocity, each axis, m/s.
    """
    found = []
    for wrong in sorted(snapshots):
        others = [other for other in sorted(snapshots) if other != wrong]
        # The wrong drone comes first.
        pairs = {k: _PairOfImages(snapshots[wrong], snapshots[k], speed) for k in others}
        priors = {k: joint_prior([stationary[wrong], stationary[k]], 0.0) for k in others}
        stated = {k: pairs[k].agreed(priors[k]) for k in others}
        for fault in FAULTS:
            ratio, matched, errors = 0.0, list[tuple[str, int, str]](), list[Array]()
            more = np.diag(np.concatenate([fault.variances, np.zeros(COUNT)]))
            for k in others:
                agreed = pairs[k].best(priors[k] + more, _starts(fault))
                ratio += agreed.log_likelihood - stated[k].log_likelihood
                own, theirs = snapshots[wrong].labels, snapshots[k].labels
                matched += [(own[i], k, theirs[j]) for i, j in agreed.pairs]
                errors.append(agreed.errors[:COUNT])
            mean = np.mean(errors, axis=0)
            found.append(Trial(Suspicion(wrong, fault, ratio), mean, tuple(matched)))
    return found


def _by_likelihood(one: Agreed) -> float:
    return one.log_likelihood


def _starts(fault: Fault) -> list[Array]:
    """Return errors (18,) at which matchings are sought: rotations are far from linear."""
    angles = [0.0]
    if fault.sensor == "compass":
        every = np.arange(-math.pi, math.pi - 1e-9, TUNING.compass_step)
        angles = every[np.abs(every) <= 3.0 * fault.sigma + 1e-9].tolist()
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
        places = [one.placed(np.zeros(COUNT)).places for one in self._both]
        middle = np.nanmean(np.concatenate(places), axis=0)
        self._rows = tuple(
            _nearest(of, middle, most) for of, most in zip(places, TUNING.robots, strict=True)
        )
        self._possible = np.array(
            [[first.class_ids[a] == second.class_ids[b] for b in self._rows[1]]
             for a in self._rows[0]]
        )  # fmt: skip
        between = speed * 1e-9 * abs(first.scene_ns - second.scene_ns)
        self._moved = between**2 * np.eye(2)

    def best(self, prior: Array, starts: list[Array]) -> Agreed:
        """Return how they agree best, sought at some errors (18,) of the drones."""
        first = [self.agreed(prior, start, 1) for start in starts]
        order = np.argsort([-one.log_likelihood for one in first], kind="stable")
        followed = [starts[k] for k in order[: TUNING.followed]]
        return max((self.agreed(prior, start) for start in followed), key=_by_likelihood)

    def agreed(self, prior: Array, start: Array | None = None, steps: int = TUNING.steps) -> Agreed:
        """Return how they agree if the drones' errors have a prior (18, 18)."""
        at = np.zeros(2 * COUNT) if start is None else start
        found = Agreed(-math.inf, (), at)
        for _ in range(steps):
            first, second = (
                one.placed(errors).some(rows)
                for one, errors, rows in zip(
                    self._both, (at[:COUNT], at[COUNT:]), self._rows, strict=True
                )
            )
            if not (np.isfinite(first.places).all() and np.isfinite(second.places).all()):
                break
            found = self._linear(first, second, at, prior)
            if not found.pairs:
                break
            at = found.errors
        return found

    def _linear(self, first: Placed, second: Placed, at: Array, prior: Array) -> Agreed:
        """Return how they agree by places and derivatives at some errors (18,)."""
        m, count = len(first.places), len(first.places) + len(second.places)
        by_errors = np.zeros((count, 2, 2 * COUNT))
        by_errors[:m, :, :COUNT], by_errors[m:, :, COUNT:] = first.by_errors, second.by_errors
        places = np.concatenate([first.places, second.places]) - by_errors @ at
        flat = by_errors.reshape(-1, 2 * COUNT)
        covariance = (flat @ prior @ flat.T).reshape(count, 2, count, 2)
        every = np.arange(count)
        covariance[every, :, every] += np.concatenate([first.white + self._moved, second.white])
        candidates = Candidates.of(places, covariance, self._possible)
        shown = self._both[0].drone, self._both[1].drone
        first_in_view = shown[1].shows(at[COUNT:], first.places, first.white)
        second_in_view = shown[0].shows(at[:COUNT], second.places, second.white)
        if len(self._rows[0]) < len(self._both[0].labels):
            second_in_view[:] = 0.0  # it may be one of those that were left out
        best = matchings(candidates, first_in_view, second_in_view)[0]
        likely = best.gain + missed(first_in_view).sum() + missed(second_in_view).sum()
        errors = _posterior(candidates, by_errors, prior, best.pairs)
        pairs = tuple((int(self._rows[0][i]), int(self._rows[1][j])) for i, j in best.pairs)
        return Agreed(float(likely), pairs, errors)


def _nearest(places: Array, middle: Array, most: int) -> NDArray[np.intp]:
    """Return the rows of the robots (n, 2) nearest to a point, in their order."""
    apart = np.square(places - middle).sum(axis=1)
    return np.sort(np.argsort(apart, kind="stable")[:most])


def _posterior(candidates: Candidates, by_errors: Array, prior: Array, pairs: Pairs) -> Array:
    """Return the errors (18,) by which pairs come closest.

    Args:
        candidates: of which the pairs are some.
        by_errors: (m + n, 2, 18) derivatives of the robots' places.
        prior: (18, 18) of the errors.
        pairs: of rows in the two sets.
    """
    if not pairs:
        return np.zeros(2 * COUNT)
    chosen = set(pairs)
    both = zip(candidates.first.tolist(), candidates.second.tolist(), strict=True)
    some = np.array([k for k, pair in enumerate(both) if pair in chosen])
    i, j = candidates.first[some], candidates.second[some] + candidates.count
    H = (by_errors[j] - by_errors[i]).reshape(-1, 2 * COUNT)
    size = 2 * len(some)
    spread = candidates.covariance[some][:, :, some].reshape(size, size)
    found: Array = -prior @ H.T @ np.linalg.solve(spread, candidates.offsets[some].ravel())
    return found
