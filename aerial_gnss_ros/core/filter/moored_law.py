# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A joint law in which some robots are moored or drift with one current, and the others swim.

What is moored swings about a place: its four numbers are that place (East, North) and how far off
it is seen (a Gauss-Markov process), which stands for boxes whose errors last as well. The place
moves with the current, which is one for all: a robot of its own that no image shows, whose velocity
counts. It is zero for good, or unknown and changes within minutes (Gauss-Markov): two laws.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.state import JointState, copy_robot, inverse_of_errors
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.models.motion_model import MotionModel, MotionOf
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MooredLawTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    current_mps: float = 0.3
    """One sigma of an unknown current, each axis, and of what else a robot may swim that has to be
    told from it, m/s. Judged."""
    slower_mps: tuple[float, float] = (0.1, 0.03)
    """Other sigmas that it is as likely to have, m/s. Judged."""
    current_s: float = 300.0
    """Time within which a current changes, s: with the wind, near shore and at a front. Judged."""
    apart_mps: float = 0.005
    """One sigma by which the velocity of what drifts or is moored differs from the current's, or
    from zero, each axis, m/s. Judged."""
    sway_s: float = 3.0
    """Time constant of swinging, and of boxes' lasting errors, s. Judged."""
    first_sway_m: float = 0.1
    """One sigma of the swing at first, each axis, m. Judged."""


TUNING = MooredLawTuning()

CURRENT = -1
"""Number of the robot in `ids` whose velocity is the current."""


class MooredLaw(JointState):
    """Some robots are moored or drift.

    Attributes:
        sway: (n,) 1 for these, else 0.
        variance: of their swing, each axis, m².
        current_sigma: of the current when nothing is known of it, each axis, m/s; 0: there is none.
    """

    sway: Array
    variance: float
    current_sigma: float

    @classmethod
    def of(cls, base: JointState, adrift: bool) -> MooredLaw:
        """Return a law in which no robot is moored yet, and which doubts nothing.

        Args:
            base: the law that lets all robots swim.
            adrift: whether there is a current.
        """
        law = cls(base.covariance)
        law.copy(base)
        law.variance = TUNING.first_sway_m**2
        law.sway = np.zeros(len(base))
        place = np.zeros((1, 4))
        place[0, :2] = base.robots[:, :2].mean(axis=0)
        law.current_sigma = TUNING.current_mps if adrift else 0.0
        variances = np.array([1.0, 1.0, law.current_sigma**2, law.current_sigma**2])
        law.append(np.array([-1]), place, np.zeros((1, 4, COUNT)), np.diag(variances)[None])
        law.ids[-1] = CURRENT
        return law

    def without_current(self) -> MooredLaw:
        """Return a law of the same robots in which the current is known to be zero."""
        law = copy.deepcopy(self)
        law.view, law.camera = self.view, self.camera
        c = _velocity(self.current)
        cross = law.covariance[c]
        gain = np.linalg.solve(cross[:, c] + 1e-12 * np.eye(2), cross)
        law.mean -= law.mean[c] @ gain
        law.covariance -= cross.T @ gain
        law.mean[c] = law.covariance[c] = law.covariance[:, c] = 0.0
        law.current_sigma = 0.0
        return law

    @property
    def current(self) -> int:
        """The place of the current among the robots."""
        place: int = self.ids.tolist().index(CURRENT)
        return place

    def append(self, rows: Indices, state: Array, by_platform: Array, own: Array) -> None:
        """Add robots that swim (see `JointState`)."""
        super().append(rows, state, by_platform, own)
        self.sway = np.concatenate([self.sway, np.zeros(len(rows))])

    def drop(self, slots: Indices) -> None:
        """Forget robots (see `JointState`)."""
        kept = np.ones(len(self), dtype=np.bool_)
        kept[slots] = False
        super().drop(slots)
        self.sway = self.sway[kept]

    def motion(
        self, default: MotionModel, slots: Indices | slice = slice(None)
    ) -> MotionModel | MotionOf[Array]:
        """Return how robots move; those that sway as such where all are asked for."""
        inner = super().motion(default, slots)
        if not isinstance(slots, slice):
            return inner
        return _Swaying(inner, self)

    def predict(self, seconds: float, keep: Array, stationary: Array, motion: MotionModel) -> None:
        """Move on in time (see `JointState`)."""
        if seconds <= 0.0:
            return
        super().predict(seconds, keep, stationary, motion)
        sways, c = np.flatnonzero(self.sway), self.current
        n, P = len(self), self.covariance
        self.robots[sways, :2] += seconds * self.robots[c, 2:]
        down, across = P[COUNT:].reshape(n, 4, -1), P[:, COUNT:].reshape(-1, n, 4)
        down[sways, :2] += seconds * down[c, 2:]
        across[:, sways, :2] += seconds * across[:, None, c, 2:]

    def fit(
        self, slots: Indices, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> Outcome:
        """Update robots with pixels, of which none is too fast (see `update.correct`)."""
        return correct(self, slots, pixels, view, model, np.inf, level)

    def take(self, base: JointState, slot: int) -> None:
        """Take in a robot of the law that lets all swim."""
        added = copy_robot(base, slot, self)
        self.ids[added] = base.ids[slot]

    def odds(self, slots: list[int]) -> Array:
        """Return the log odds (m,) that robots go with the current, to any other velocity, nats."""
        v, c = velocities_of(slots), _velocity(self.current)
        P = self.covariance
        cross = P[v[:, :, None], c]
        spread = P[v[:, :, None], v[:, None]] + P[np.ix_(c, c)] - cross - cross.swapaxes(1, 2)
        return velocity_odds(self.mean[v] - self.mean[c], spread)

    def known_current(self) -> tuple[Array, Array]:
        """Return the current (2,) and its covariance (2, 2), m/s, m²/s²."""
        begin = COUNT + 4 * self.current + 2
        c = slice(begin, begin + 2)
        return self.mean[c].copy(), self.covariance[c, c].copy()

    def slow_odds(self) -> float:
        """Return how much likelier the flight is if the current may be slow, nats.

        The state takes it for Gaussian with `current_mps`. A mixture over `slower` sigmas has
        heavier tails and a peak: its likelihood to the Gaussian's is the posterior mean of the
        ratio of both densities.
        """
        mean, covariance = self.known_current()
        (x, y), ((a, b), (_, d)) = mean.tolist(), covariance.tolist()
        stated = 1.0 / TUNING.current_mps**2
        total = 0.0
        for sigma in TUNING.slower_mps:
            # E[exp(-more c'c / 2)] of a Gaussian c; of 1 + more P, the covariance P.
            more = 1.0 / sigma**2 - stated
            east, north, both = 1.0 + more * a, 1.0 + more * d, more * b
            size = east * north - both * both
            squared = (north * x * x - 2.0 * both * x * y + east * y * y) / size
            total += math.exp(-0.5 * more * squared) / (math.sqrt(size) * sigma**2 * stated)
        return math.log((total + 1.0) / (1.0 + len(TUNING.slower_mps)))

    def still_odds(self) -> float:
        """Return the log odds that the current is zero, to any other one, nats."""
        return float(velocity_odds(*self.known_current()))

    def _difference(self, one: Indices, other: Indices) -> Array:
        rows: Array = self.covariance[one] - self.covariance[other]
        return rows

    def moor(self, slot: int) -> None:
        """Take in that a robot goes with the current, and swings."""
        v, c = _velocity(slot), _velocity(self.current)
        cross = self._difference(v, c)
        spread = cross[:, v] - cross[:, c] + TUNING.apart_mps**2 * np.eye(2)
        gain = np.linalg.solve(spread, cross)
        self.mean = self.mean - (self.mean[v] - self.mean[c]) @ gain
        P = self.covariance = self.covariance - cross.T @ gain
        p = v - 2
        self.mean[v] = 0.0
        P[v] = P[:, v] = 0.0
        for i, j in zip(p.tolist(), v.tolist(), strict=True):
            P[i, i] += self.variance
            P[j, j] = self.variance
            P[i, j] = P[j, i] = -self.variance
        self.by_pose[slot : slot + 1, 2:] = 0.0
        self.sway[slot] = 1.0

    def join(self, moored: int, found: int, sigma: float) -> tuple[Array, Array]:
        """Condition on a moored robot being shown where another one is, whose number it gets.

        Args:
            moored: its place.
            found: the other one's.
            sigma: one sigma of how far they may be apart, m.

        Returns:
            How far (2,) they were apart, m, and the covariance (2, 2) of that, m².
        """
        a, b = COUNT + 4 * moored, COUNT + 4 * found
        across = self._difference(np.arange(b, b + 2), np.arange(a, a + 2))
        across -= self.covariance[a + 2 : a + 4]
        spread = across[:, b : b + 2] - across[:, a : a + 2] - across[:, a + 2 : a + 4]
        spread = spread + sigma**2 * np.eye(2)
        place, swing = self.robots[moored, :2], self.robots[moored, 2:]
        apart = self.robots[found, :2] - (place + swing)
        gain = np.linalg.solve(spread, across)
        self.mean = self.mean - apart @ gain
        self.covariance = self.covariance - across.T @ gain
        self.ids, self.rows, self.unseen = (
            _with(one, moored, one[found]) for one in (self.ids, self.rows, self.unseen)
        )
        return apart, spread

    def own_covariances(self, slots: Indices) -> Array:
        """Return covariances (m, 2, 2) of where robots are seen if the platform were known, m²."""
        sway, n = self.sway[slots, None, None], len(self)
        rows = self.covariance[COUNT:].reshape(n, 4, -1)[slots]
        shown = rows[:, :2] + sway * rows[:, 2:]
        by_platform = shown[:, :, :COUNT]
        with_own = shown[:, :, COUNT:].reshape(-1, 2, n, 4)[np.arange(len(slots)), :, slots]
        own = with_own[:, :, :2] + sway * with_own[:, :, 2:]
        return given_errors(own, by_platform, self.covariance[:COUNT, :COUNT])

    def release(self, slot: int, state: Array, covariance: Array) -> None:
        """Take in that a robot swims after all.

        Args:
            slot: its place.
            state: (4,) how far it is from where it is shown, and its velocity to the current's, m,
                m/s.
            covariance: (4, 4) of that.
        """
        v, c = _velocity(slot), _velocity(self.current)
        p, P = v - 2, self.covariance
        self.mean[p] += self.mean[v]
        P[p] += P[v]
        P[:, p] += P[:, v]
        self.mean[v] = self.mean[c]
        P[v] = P[c]
        P[:, v] = P[:, c]
        self.sway[slot] = 0.0
        self.manoeuvre_noise.strength[slot] = 1.0
        own = np.concatenate([p, v])
        self.mean[own] += state
        self.covariance[np.ix_(own, own)] += covariance

    def jointly_published(self) -> tuple[Array, Array]:
        """Return all that is published (9 + 4 n,), the platform's errors first, and its covariance.

        See `published`; what is said there of each robot alone is added to its own block.
        """
        n, mean, covariance = len(self), self.mean.copy(), self.covariance.copy()
        self.put_published(mean, covariance, COUNT)
        blocks = covariance[COUNT:, COUNT:].reshape(n, 4, n, 4)
        every = np.arange(n)
        blocks[every, :, every] = self.published()[1]
        return mean, covariance

    def put_published(self, mean: Array, covariance: Array, first: int) -> None:
        """Put half of the swing into places, and the current into velocities, of all that sway.

        Args:
            mean: (first + 4 n,) of errors and robots, changed in place.
            covariance: of these, likewise.
            first: number of errors.
        """
        v = first + 4 * np.flatnonzero(self.sway)[:, None] + np.array([2, 3])
        c = first + 4 * self.current + np.array([2, 3])
        for each in (mean, covariance, covariance.T):
            each[v - 2] += 0.5 * each[v]
            each[v] = each[c]

    def published(self) -> tuple[Array, Array]:
        """Return states (n, 4) and their covariances (n, 4, 4).

        What a robot swings is its own, or an error of its boxes: either may be.
        """
        n, sway = len(self), self.sway[:, None]
        c, robots = _velocity(self.current), self.robots
        with_current = self.covariance[COUNT:, c].reshape(n, 4, 2)
        current = self.covariance[np.ix_(c, c)]
        # Half of the swing is the robot's; a velocity is the current's where robots sway.
        mean = robots.copy()
        mean[:, :2] += 0.5 * sway * robots[:, 2:]
        mean[:, 2:] += sway * (self.mean[c] - robots[:, 2:])
        own = self.blocks()
        blocks = own.copy()
        p, b = slice(0, 2), slice(2, 4)
        each = sway[:, None]
        half = 0.5 * each * own[:, p, b]
        blocks[:, p, p] += half + half.swapaxes(1, 2) + 0.25 * each * own[:, b, b]
        both = with_current[:, :2] + 0.5 * with_current[:, 2:]
        blocks[:, p, b] += each * (both - own[:, p, b])
        blocks[:, b, p] = blocks[:, p, b].swapaxes(1, 2)
        blocks[:, b, b] += each * (current + TUNING.apart_mps**2 * np.eye(2) - own[:, b, b])
        swing = 0.5 * sway * robots[:, 2:]
        blocks[:, p, p] += swing[:, :, None] * swing[:, None]
        return mean, blocks


class _Swaying(MotionOf[Array]):
    """How robots move of which some sway."""

    def __init__(self, inner: MotionModel | MotionOf[Array], law: MooredLaw) -> None:
        super().__init__(np.asarray(inner.acceleration), np.asarray(inner.speed_sigma))
        self._inner, self._law = inner, law

    def step(
        self, seconds: float, unseen: Array, strength: Array | float = 1.0
    ) -> tuple[Array, Array | None, Array]:
        """Return reach, kept velocity and noise of a time step (see `MotionOf`)."""
        law = self._law
        sways, c = law.sway > 0.0, law.current
        swims = unseen * ~sways
        swims[c] = 0.0  # no image ever shows the current
        reach, kept, noise = self._inner.step(seconds, swims, strength)
        kept = np.ones(len(law)) if kept is None else kept
        keep = math.exp(-seconds / TUNING.sway_s)
        reach[sways], kept[sways] = 0.0, keep
        noise[sways] = 0.0, 0.0, (1.0 - keep * keep) * law.variance
        keep = math.exp(-seconds / TUNING.current_s)
        reach[c], kept[c] = 0.0, keep
        noise[c] = 0.0, 0.0, (1.0 - keep * keep) * law.current_sigma**2
        return reach, kept, noise


def given_errors(own: Array, with_errors: Array, errors: Array) -> Array:
    """Return covariances (m, 2, 2) of positions if the platform's errors were known, m².

    Args:
        own: (m, 2, 2) of the positions, m².
        with_errors: (m, 2, k) with these errors.
        errors: (k, k) covariance of the errors.
    """
    found: Array = own - with_errors @ inverse_of_errors(errors) @ with_errors.swapaxes(1, 2)
    return found


def _with(values: Any, place: int, value: Any) -> Any:
    """Return a copy with another value at a place: what others share is not changed."""
    found = values.copy()
    found[place] = value
    return found


def _velocity(slot: int) -> Indices:
    """Return where in the state a robot's velocity is (2,)."""
    places: Indices = COUNT + 4 * slot + np.array([2, 3])
    return places


def velocities_of(slots: list[int]) -> Indices:
    """Return where in the state robots' velocities are (m, 2)."""
    places: Indices = COUNT + 4 * np.array(slots, np.intp)[:, None] + np.array([2, 3])
    return places


def velocity_odds(value: Array, covariance: Array) -> Array:
    """Return the log odds (…) that values (…, 2) are zero, to any of a current's sigma, nats.

    The Savage-Dickey ratio: of the densities at zero.
    """
    squared, size = mahalanobis(value, covariance + TUNING.apart_mps**2 * np.eye(2))
    odds: Array = 2.0 * math.log(TUNING.current_mps) - 0.5 * (size + squared)
    return odds
