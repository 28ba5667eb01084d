# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Joint Gaussian of the platform's errors and some robots: prediction and external updates.

Updates by boxes are in `update`, the layout of rows and columns in `state_arrays`.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.velocity_changes import UnwatchedChanges
from aerial_gnss_ros.core.filter.state_arrays import Indices, StateArrays
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]

_ENTRIES = ((0, 0), (1, 1), (0, 2), (1, 3), (2, 0), (3, 1), (2, 2), (3, 3))
_NOISE_OF_ENTRY = np.array([0, 0, 1, 1, 1, 1, 2, 2])


@lru_cache(maxsize=64)
def _own_places(n: int) -> Indices:
    """Return where, in the covariance of n robots laid flat, entries of their noise are, (8 n,)."""
    entries, size = np.array(_ENTRIES, dtype=np.intp), COUNT + 4 * n
    row, column = (COUNT + 4 * np.arange(n)[:, None] + entries.T[:, None, :]).reshape(2, -1)
    flat: Indices = row * size + column
    flat.flags.writeable = False
    return flat


@dataclass(frozen=True)
class StateTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    wide_m: float = 1000.0
    """Sigma of an unknown position, m. Judged."""


TUNING = StateTuning()


class JointState(StateArrays):
    """The platform's errors and robots together."""

    def copy(self, other: JointState) -> None:
        """Have the robots and the distribution of another state, but suspect no rotation."""
        self.rows, self.unseen, self.ids = other.rows.copy(), other.unseen.copy(), other.ids
        self.own = other.own.copy()
        self.velocity_changes = UnwatchedChanges()
        self.assume(other)

    def assume(self, other: JointState) -> None:
        """Take over the distribution of another state of the same robots."""
        self.mean, self.covariance = other.mean.copy(), other.covariance.copy()
        self.by_pose, self.by_errors = other.by_pose.copy(), other.by_errors.copy()
        self.camera, self.view = other.camera, other.view
        self.manoeuvre_noise = copy.deepcopy(other.manoeuvre_noise)

    def predict(self, seconds: float, keep: Array, stationary: Array, motion: MotionModel) -> None:
        """Predict to a later time.

        Args:
            seconds: length of the step, s.
            keep: (9,) `PlatformModel.decay` of this time.
            stationary: (9, 9) stationary covariance.
            motion: motion model of the robots.
        """
        if seconds <= 0.0:
            return
        P = self.covariance
        both = keep[:, None] * keep
        self.mean[:COUNT] *= keep
        P[:COUNT, :COUNT] *= both
        P[:COUNT, :COUNT] += (1.0 - both) * stationary
        each = self.motion(motion)
        density = each.acceleration**2
        stated = density * seconds * self.manoeuvre_noise.strength
        self.velocity_changes.predict(seconds, stated)
        n = len(self.rows)
        if not n:
            return
        self.manoeuvre_noise.predict(seconds, density)
        reach, kept, noise = each.step(seconds, self.unseen, self.manoeuvre_noise.strength)
        P[:COUNT, COUNT:] *= keep[:, None]
        P[COUNT:, :COUNT] *= keep
        robots = self.mean[COUNT:].reshape(n, 4)
        robots[:, :2] += reach[:, None] * robots[:, 2:]
        by_pose, k = self.by_pose, len(self.by_pose)
        by_pose[:, :2] += reach[:k, None, None] * by_pose[:, 2:]
        down = P[COUNT:].reshape(n, 4, -1)
        down[:, :2] += reach[:, None, None] * down[:, 2:]
        across = P[:, COUNT:].reshape(-1, n, 4)
        for axis in (0, 1):  # apart: numpy is slow where the innermost loop is over two
            across[:, :, axis] += reach * across[:, :, axis + 2]
        if kept is not None:
            # One or two misses are no evidence of a manoeuvre; later it may have turned.
            beyond = np.maximum(noise[:, 2] - stated, 0.0)
            self.velocity_changes.note_inflation(
                slice(None), beyond * (self.unseen <= MOTION_MODEL.held_s)
            )
            robots[:, 2:] *= kept[:, None]
            by_pose[:, 2:] *= kept[:k, None, None]
            down[:, 2:] *= kept[:, None, None]
            across[:, :, 2:] *= kept[:, None]
        # each robot's block: pp, pv, vp, vv on both axes
        P.reshape(-1)[_own_places(n)] += noise.take(_NOISE_OF_ENTRY, axis=1).ravel()
        self.unseen = self.unseen + seconds

    def tie(self, first: int, second: int, sigma: float) -> float:
        """Condition on two robots having the same position.

        Args:
            first: index in `rows`.
            second: likewise.
            sigma: one sigma of their distance, m.

        Returns:
            Log density of their distance, which was zero, up to a constant, nats.
        """
        a, b = COUNT + 4 * first, COUNT + 4 * second
        apart = self.covariance[a : a + 2] - self.covariance[b : b + 2]
        spread = apart[:, a : a + 2] - apart[:, b : b + 2] + sigma**2 * np.eye(2)
        gain = np.linalg.solve(spread, apart)
        before = self.robots[first, 2:].copy()
        off = self.mean[a : a + 2] - self.mean[b : b + 2]
        squared, size = mahalanobis(off, spread)
        self.mean -= off @ gain
        self.covariance -= apart.T @ gain
        if self.unseen[first] <= MOTION_MODEL.held_seen_s:
            unknown = float(self.covariance[b + 2, b + 2] + self.covariance[b + 3, b + 3])
            self.velocity_changes.inherit(first, second, self.robots[second, 2:] - before, unknown)
        self.manoeuvre_noise.inherit(first, second)
        return -0.5 * float(squared + size)

    def inflate_velocities(self, slots: Indices, speed: Array | float, seconds: float) -> None:
        """Inflate the covariance by an unforeseen change of velocity.

        Args:
            slots: (m,) indices in `rows`.
            speed: one sigma of the change, each axis, m/s.
            seconds: time since it happened, s.
        """
        self.velocity_changes.note_inflation(slots, speed**2)
        place = COUNT + 4 * np.asarray(slots, np.intp)
        for axis in (0, 1):
            p, v = place + axis, place + axis + 2
            self.covariance[p, p] += (seconds * speed) ** 2
            self.covariance[p, v] += seconds * speed**2
            self.covariance[v, p] += seconds * speed**2
            self.covariance[v, v] += speed**2

    def settle(self, error: int, mean: float, sigma: float) -> None:
        """Condition on one of the platform's errors as estimated elsewhere.

        Correlated states are updated accordingly.

        Args:
            error: its index in `PLATFORM`.
            mean: of it.
            sigma: of it.
        """
        variance = float(self.covariance[error, error])
        if variance <= 0.0:
            return
        with_it = self.covariance[:, error] / variance
        self.mean += (mean - float(self.mean[error])) * with_it
        self.covariance += (sigma**2 - variance) * np.outer(with_it, with_it)

    def discount(
        self, factor: float, platform: Array, speed: Array | float, wider: Array | float = 1.0
    ) -> None:
        """Let all that boxes have told count less: their noise was larger than assumed.

        Of the information of the state what is not the prior's is divided by the factor: with P the
        covariance and D the prior's inverse, P' = (P⁻¹ / f + (1 / g - 1 / f) D)⁻¹.

        Args:
            factor: f, of the variance of the noise, above 1.
            platform: (9, 9) prior covariance of the platform's errors, except the latency, of which
                boxes tell nothing here.
            speed: one sigma of robots' unknown velocities, each axis, m/s; (n,) or of all.
            wider: (9,) factor g of that prior covariance from now on, at most f; or of all.
        """
        P, variances = self.covariance, np.zeros((len(self), 4))
        variances[:, 2:] = np.square(np.broadcast_to(speed, (len(self),)))[:, None]
        prior = np.concatenate([platform.diagonal(), variances.ravel()])
        prior[LATENCY] = P[LATENCY, LATENCY]
        more = np.full(len(prior), factor)
        more[:COUNT] /= wider
        (known,) = np.nonzero(prior)
        missing = np.sqrt((more[known] - 1.0) / prior[known])
        through = P[:, known] * missing
        spread = np.eye(len(known)) + through[known] * missing[:, None]
        told = self.mean[known] * missing
        told[known == LATENCY] = 0.0
        both = np.linalg.solve(spread, np.concatenate([through.T, told[:, None]], axis=1))
        self.mean = self.mean - through @ both[:, -1]
        P = factor * (P - through @ both[:, :-1])
        self.covariance = 0.5 * (P + P.T)

    def doubt_platform(self, factor: float, platform: Array) -> tuple[Array, Array]:
        """Let what boxes have told of the platform's errors count less (see `discount`).

        Robots keep their distributions given these errors.

        Args:
            factor: by which the information that is not the prior's is divided, at least 1.
            platform: (9, 9) prior covariance of the platform's errors.

        Returns:
            (9,) by what their mean changes, (9, 9) and their covariance.
        """
        if factor <= 1.0:
            return np.zeros(COUNT), np.zeros((COUNT, COUNT))
        P = self.covariance
        before = JointState(P[:COUNT, :COUNT])
        before.mean = self.mean[:COUNT].copy()
        before.discount(factor, platform, 0.0)
        moved = before.mean - self.mean[:COUNT]
        wider = before.covariance - P[:COUNT, :COUNT]
        through = P[:, :COUNT] @ inverse_of_errors(P[:COUNT, :COUNT])
        self.mean = self.mean + through @ moved
        self.covariance = P + through @ wider @ through.T
        return moved, wider

    def forget(self, slots: Indices, platform: Array, speed: Array | float) -> None:
        """Reset the platform's errors except the latency, and some robots.

        Args:
            slots: (m,) indices of these robots in `rows`.
            platform: (9, 9) new covariance of the platform's errors, except the latency's.
            speed: one sigma of these robots' unknown velocities, each axis, m/s.
        """
        self.mean[:LATENCY] = 0.0
        P = self.covariance
        latency = float(P[LATENCY, LATENCY])
        P[:COUNT] = P[:, :COUNT] = 0.0
        P[:COUNT, :COUNT] = platform
        P[LATENCY, LATENCY] = latency
        self.forget_robots(slots, speed)

    def forget_robots(self, slots: Indices, speed: Array | float) -> None:
        """Forget what is known of some robots; they may be anywhere around their means.

        Args:
            slots: (m,) indices of these robots in `rows`.
            speed: one sigma of their unknown velocities, each axis, m/s.
        """
        P, own = self.covariance, of_robots(slots)
        self.robots[slots, 2:] = 0.0
        P[own] = P[:, own] = 0.0
        variances = np.full((len(slots), 4), TUNING.wide_m**2)
        variances[:, 2] = variances[:, 3] = np.square(speed)
        P[own, own] = variances.ravel()

    def shift(self, jump: Array) -> None:
        """Move robots and camera with an accepted jump of the GNSS position.

        Relative positions stay as well known. That either position may be wrong is not part of this
        state, which would use boxes to explain it (`AttitudeAmbiguity`).

        Args:
            jump: (2,) East, North, m.
        """
        self.robots[:, :2] += jump
        self.camera = self.camera + np.append(jump, 0.0)  # not in place: laws may share it

    def carry(self, change: Array) -> None:
        """Let robots' errors change by the platform's: P = L P L', L the identity and `change`.

        Args:
            change: (k, 4, 9) of the first k robots' states by the platform's errors.
        """
        flat, P = change.reshape(-1, COUNT), self.covariance
        end = COUNT + len(flat)
        P[COUNT:end] += flat @ P[:COUNT]
        P[:, COUNT:end] += P[:, :COUNT] @ flat.T


def of_robots(slots: Indices) -> Indices:
    """Return where in a joint state's mean robots (m,) have their numbers (4 m,)."""
    places: Indices = (COUNT + 4 * slots[:, None] + np.arange(4)).ravel()
    return places


def copy_robot(source: JointState, slot: int, target: JointState) -> int:
    """Copy a robot into another group and return its slot there.

    Its distribution given the platform's errors, p(robot | errors), is copied, which follows from
    its own boxes. The errors stay those of the target's group, so no box counts twice.
    """
    own = slice(COUNT + 4 * slot, COUNT + 4 * slot + 4)
    platform, cross = source.covariance[:COUNT, :COUNT], source.covariance[own, :COUNT]
    by_platform = cross @ inverse_of_errors(platform)
    given = source.covariance[own, own] - by_platform @ cross.T
    state = source.mean[own] + by_platform @ (target.mean[:COUNT] - source.mean[:COUNT])
    target.append(source.rows[[slot]], state[None], by_platform[None], given[None])
    target.unseen[-1], target.own[:, -1] = source.unseen[slot], source.own[:, slot]
    target.manoeuvre_noise.copy(source.manoeuvre_noise, slot)
    target.velocity_changes.copy(source.velocity_changes, slot)
    return len(target) - 1


def inverse_of_errors(covariance: Array) -> Array:
    """Return the inverse of a covariance of the platform's errors; 0 for those known exactly.

    By the errors' correlations, whose eigenvalues are taken to be at least 1e-7: smaller ones are
    rounding, which differs between machines.
    """
    sizes = np.sqrt(covariance.diagonal())
    scales = np.divide(1.0, sizes, out=np.zeros(len(sizes)), where=sizes > 0.0)
    both = scales[:, None] * scales
    correlations = covariance * both
    correlations.reshape(-1)[:: len(sizes) + 1] += 1e-7
    found: Array = np.linalg.inv(correlations) * both
    return found
