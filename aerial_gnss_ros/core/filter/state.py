# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One normal law over the platform's errors and some robots; prediction in time.

State: the platform's errors (`platform_model.PLATFORM`), then east, north, velocity east, velocity
north (m, m/s, in `map`) of each robot. Given the platform's errors robots move independently, but
their covariance is carried whole: what was measured while the platform's errors wandered leaves
robots correlated in ways that the present errors do not explain.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.manoeuvre_noise import ManoeuvreNoise
from aerial_gnss_ros.core.faults.rotation_fault import RotationFault
from aerial_gnss_ros.core.faults.velocity_changes import VelocityChanges
from aerial_gnss_ros.core.models.measurement_model import POSE_COUNT
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import MotionModel, MotionOf
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

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
    """Sigma of a place of which nothing is known. Judged."""


TUNING = StateTuning()


_ALL = slice(None)


class JointState:
    """The platform's errors and robots together.

    Attributes:
        mean: (7 + 4 n,).
        covariance: (7 + 4 n, 7 + 4 n).
        rows: (n,) which robots of the whole program these are.
        unseen: (n,) time since each was measured, s.
        manoeuvre_noise: how hard each turns.
        velocity_changes: of each, lately.
        rotation_fault: whether the camera turns by itself.
        by_pose: (k, 4, 6) `state_jacobian` of the first k robots with which the covariance goes,
            see `linearization`; those after them are new.
        camera: (3,) from where that was taken: place of the camera, m; NaN at first.
        by_errors: (6, 7) `pose_by_errors` of that time.
        view: the image of that time.
    """

    def __init__(self, covariance: Array, rotation_fault: RotationFault | None = None) -> None:
        """Begin without robots.

        Args:
            covariance: (7, 7) of the platform's errors.
            rotation_fault: of the camera, which it shares with others.
        """
        self.mean = np.zeros(COUNT)
        self.covariance = covariance.copy()
        self.rows: Indices = np.zeros(0, np.intp)
        self.unseen: Array = np.zeros(0)
        self.own: Array = np.zeros((2, 0))
        self.manoeuvre_noise = ManoeuvreNoise()
        self.velocity_changes = VelocityChanges()
        self.rotation_fault = rotation_fault or RotationFault()
        self.by_pose = np.zeros((0, 4, POSE_COUNT))
        self.camera = np.full(3, np.nan)
        self.by_errors = np.zeros((POSE_COUNT, COUNT))
        self.view: object = None

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def robots(self) -> Array:
        """(n, 4) means; a view."""
        return self.mean[COUNT:].reshape(-1, 4)

    def blocks(self) -> Array:
        """Return the robots' own covariances (n, 4, 4)."""
        n = len(self.rows)
        blocks = self.covariance[COUNT:, COUNT:].reshape(n, 4, n, 4)
        return blocks.diagonal(axis1=0, axis2=2).transpose(2, 0, 1).copy()

    def motion(
        self, default: MotionModel, slots: Indices | slice = _ALL
    ) -> MotionModel | MotionOf[Array]:
        """Return how some robots move.

        Args:
            default: of those whose class has no parameters of its own.
            slots: their places in `rows`.
        """
        own = self.own[:, slots]
        if np.isnan(own).all():
            return default
        both = (default.acceleration, default.speed_sigma)
        accelerations, speeds = np.where(np.isnan(own), np.array(both)[:, None], own)
        return MotionOf(accelerations, speeds)

    def fastest(self, slots: Indices, default: float) -> Array | float:
        """Return the fastest speeds of some robots; `default` where no class has its own, m/s."""
        speeds = self.own[1, slots]
        own = ~np.isnan(speeds)
        return np.where(own, 2.0 * speeds, default) if own.any() else default

    def positions(self) -> tuple[Array, Array, Array]:
        """Return the robots' positions (n, 2) and how well they are known; views.

        Their covariances (n, 2, 2), and those with the platform's errors (n, 2, 7).
        """
        n, P = len(self.rows), self.covariance
        own = P[COUNT:, COUNT:].reshape(n, 4, n, 4).diagonal(axis1=0, axis2=2).transpose(2, 0, 1)
        with_platform = P[COUNT:, :COUNT].reshape(n, 4, COUNT)[:, :2]
        return self.mean[COUNT:].reshape(n, 4)[:, :2], own[:, :2, :2], with_platform

    def predict(self, seconds: float, keep: Array, stationary: Array, motion: MotionModel) -> None:
        """Move on in time.

        Args:
            seconds: length of the step, s.
            keep: (7,) `PlatformModel.decay` of this time.
            stationary: (7, 7) covariance that they tend to.
            motion: how robots move.
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
        across[:, :, :2] += reach[:, None] * across[:, :, 2:]
        if kept is not None:
            # A box or two that did not fit say nothing of the robot; later it may have turned.
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

    def add(
        self,
        rows: Indices,
        positions: Array,
        by_platform: Array,
        white: Array,
        speed: float,
        own: Array | None = None,
    ) -> None:
        """Take in robots, each from one measurement through the platform's errors.

        Args:
            rows: (m,) their numbers.
            positions: (m, 2) where they are by the present estimate of the platform's errors, m.
            by_platform: (m, 2, 7) how these move with the platform's errors.
            white: (m, 2, 2) white covariance of the positions, m².
            speed: one sigma of the unknown velocity, each axis, m/s.
            own: (2, m) accelerations and speed sigmas where classes have their own, else NaN.
        """
        m = len(rows)
        state, through, alone = np.zeros((m, 4)), np.zeros((m, 4, COUNT)), np.zeros((m, 4, 4))
        state[:, :2], through[:, :2], alone[:, :2, :2] = positions, by_platform, white
        alone[:, 2:, 2:] = speed**2 * np.eye(2)
        if own is not None:
            speeds = np.where(np.isnan(own[1]), speed, own[1])
            alone[:, 2:, 2:] = np.square(speeds)[:, None, None] * np.eye(2)
        self.append(rows, state, through, alone)
        if own is not None:
            self.own[:, len(self) - m :] = own

    def append(self, rows: Indices, state: Array, by_platform: Array, own: Array) -> None:
        """Add robots whose law given the platform's errors is known.

        Args:
            rows: (m,) their numbers.
            state: (m, 4) their means by the present estimate of the platform's errors, m, m/s.
            by_platform: (m, 4, 7) how these move with the platform's errors.
            own: (m, 4, 4) their covariances given the platform's errors.
        """
        m, old = len(rows), len(self.mean)
        grown = np.zeros((old + 4 * m, old + 4 * m))
        grown[:old, :old] = self.covariance
        flat = by_platform.reshape(4 * m, COUNT)
        cross = flat @ self.covariance[:COUNT]
        grown[old:, :old] = cross
        grown[:old, old:] = cross.T
        grown[old:, old:] = cross[:, :COUNT] @ flat.T
        every = np.arange(m)
        grown[old:, old:].reshape(m, 4, m, 4)[every, :, every] += own
        self.mean = np.concatenate([self.mean, state.ravel()])
        self.covariance = grown
        self.rows = np.concatenate([self.rows, rows])
        self.unseen = np.concatenate([self.unseen, np.zeros(m)])
        self.own = np.concatenate([self.own, np.full((2, m), np.nan)], axis=1)
        self.manoeuvre_noise.add(m)
        self.velocity_changes.add(m)

    def tie(self, first: int, second: int, sigma: float) -> None:
        """Take in that two robots are at one place: what is known of one is known of the other.

        Args:
            first: place in `rows`.
            second: likewise.
            sigma: how far apart they can be after all, m.
        """
        a, b = COUNT + 4 * first, COUNT + 4 * second
        apart = self.covariance[a : a + 2] - self.covariance[b : b + 2]
        spread = apart[:, a : a + 2] - apart[:, b : b + 2] + sigma**2 * np.eye(2)
        gain = np.linalg.solve(spread, apart)
        before = self.robots[first, 2:].copy()
        self.mean -= (self.mean[a : a + 2] - self.mean[b : b + 2]) @ gain
        self.covariance -= apart.T @ gain
        if self.unseen[first] <= MOTION_MODEL.held_seen_s:
            unknown = float(self.covariance[b + 2, b + 2] + self.covariance[b + 3, b + 3])
            self.velocity_changes.inherit(first, second, self.robots[second, 2:] - before, unknown)
        self.manoeuvre_noise.inherit(first, second)

    def inflate_velocities(self, slots: Indices, speed: Array | float, seconds: float) -> None:
        """Allow for a change of velocity that nobody has foreseen.

        Args:
            slots: (m,) places in `rows`.
            speed: one sigma of the change, each axis, m/s.
            seconds: how long ago it happened, s.
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
        """Take over what is known of one of the platform's errors from elsewhere.

        The rest follows as it hangs together with it.

        Args:
            error: its place in `PLATFORM`.
            mean: of it.
            sigma: of it.
        """
        variance = float(self.covariance[error, error])
        if variance <= 0.0:
            return
        with_it = self.covariance[:, error] / variance
        self.mean += (mean - float(self.mean[error])) * with_it
        self.covariance += (sigma**2 - variance) * np.outer(with_it, with_it)

    def forget(self, slots: Indices, platform: Array, speed: Array | float) -> None:
        """Forget the platform's errors but the latency, and some robots: the next image tells.

        Args:
            slots: (m,) places of these robots in `rows`.
            platform: (7, 7) covariance of the platform's errors from now on, but for the latency's.
            speed: one sigma of these robots' unknown velocities, each axis, m/s.
        """
        self.mean[:LATENCY] = 0.0
        P, own = self.covariance, COUNT + (4 * slots[:, None] + np.arange(4)).ravel()
        latency = float(P[LATENCY, LATENCY])
        self.robots[slots, 2:] = 0.0
        P[:COUNT] = P[:, :COUNT] = 0.0
        P[own] = P[:, own] = 0.0
        P[:COUNT, :COUNT] = platform
        P[LATENCY, LATENCY] = latency
        variances = np.full((len(slots), 4), TUNING.wide_m**2)
        variances[:, 2] = variances[:, 3] = np.square(speed)
        P[own, own] = variances.ravel()

    def shift(self, jump: Array) -> None:
        """Go over to another GNSS position: the robots move with it.

        How they lie to the drone and to one another stays as well known. That either position may
        be wrong is no business of this law, which would explain boxes by it (`AttitudeAmbiguity`).

        Args:
            jump: (2,) East, North, m.
        """
        self.robots[:, :2] += jump
        self.camera[:2] += jump

    def drop(self, slots: Indices) -> None:
        """Forget the robots at some places of `rows`."""
        kept = np.ones(len(self), dtype=np.bool_)
        kept[slots] = False
        index = np.concatenate([np.ones(COUNT, np.bool_), np.repeat(kept, 4)])
        self.mean = self.mean[index]
        self.covariance = self.covariance[np.ix_(index, index)]
        self.rows, self.unseen = self.rows[kept], self.unseen[kept]
        self.own = self.own[:, kept]
        self.manoeuvre_noise.drop(kept)
        self.velocity_changes.drop(kept)
        self.by_pose = self.by_pose[kept[: len(self.by_pose)]]

    def carry(self, change: Array) -> None:
        """Let robots' errors change by the platform's: P = L P L', L the identity and `change`.

        Args:
            change: (k, 4, 7) of the first k robots' states by the platform's errors.
        """
        flat, P = change.reshape(-1, COUNT), self.covariance
        end = COUNT + len(flat)
        P[COUNT:end] += flat @ P[:COUNT]
        P[:, COUNT:end] += P[:, :COUNT] @ flat.T
