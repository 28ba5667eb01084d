# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Joint Gaussian of the platform errors of several drones and of the robots that they see.

An image of one drone depends on that drone's errors and on robots alone. These form a `JointState`,
the *active* part, which is predicted and updated as that of a single drone. The errors of all other
drones are kept beside it, with their covariances with the active part: linear maps of the active
part apply to those, and an update passes on to them by the same gain. So this is the Kalman filter
of all together, and with one drone nothing but its joint filter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dtrsm

from aerial_gnss_ros.core.filter.linearization import CameraView, relinearize
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.update import Linear, Outcome, correct, linearise
from aerial_gnss_ros.core.fleet.receivers import joint_prior
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.models.measurement_model import POSE_COUNT, state_jacobian
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT, GNSS, LATENCY, PlatformModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SharedStateTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    moves_mps: float = 0.1
    """Speed from which a robot tells of clocks, m/s. Judged: a slower one tells too little."""
    moves_sigmas: float = 4.0
    """Sigmas of that speed by which it must not be none. Judged."""
    stands_mps: float = 0.03
    """Speed below which it tells nothing any more, m/s: less than noise makes of it. Judged."""


TUNING = SharedStateTuning()


@dataclass
class Base:
    """Where a drone was when its last image was used, and how its errors act on its pose.

    Attributes:
        camera: (3,) position, m; NaN at first.
        by_errors: (6, 7) derivative of the pose by the drone's errors.
    """

    camera: Array
    by_errors: Array


class SharedState:
    """Platform errors of several drones, and robots.

    Args:
        stationary: (7, 7) prior covariance of each drone's errors.
        share: prior share of the receivers' variance that is common to all drones.

    Attributes:
        joint: the active drone's errors and the robots.
        active: number of the active drone.
        bases: of each drone.
        seen_by: (n,) number of the drone that measured each robot last.
    """

    def __init__(self, stationary: list[Array], share: float) -> None:
        self.joint = JointState(stationary[0])
        self.active, self._others = 0, list(range(1, len(stationary)))
        self._share = share
        size = COUNT * len(self._others)
        self._mean = np.zeros(size)
        self._cross = np.zeros((COUNT, size))  # of the active part with the others
        self._own = np.zeros((size, size))
        self.bases = [Base(np.full(3, np.nan), np.zeros((POSE_COUNT, COUNT))) for _ in stationary]
        self.seen_by: Indices = np.zeros(0, np.intp)
        self._by_pose = np.zeros((0, 4, POSE_COUNT))
        self._shown: tuple[float, Array] | None = None  # clock and velocities of an image's drone
        self._moves = np.zeros(0, np.bool_)
        self._moving = np.zeros((0, 2))  # velocity to which covariances with its clock refer
        active, between, own = self._prior(stationary)
        self._cross[:], self._own[:] = between, own
        self.joint.covariance[:] = active

    def platform(self, drone: int) -> tuple[Array, Array]:
        """Return a drone's errors (7,) and their covariance (7, 7)."""
        if drone == self.active:
            return self.joint.mean[:COUNT].copy(), self.joint.covariance[:COUNT, :COUNT].copy()
        own = self._place(drone)
        return self._mean[own].copy(), self._own[own, own].copy()

    def assume(self, drone: int, errors: Array) -> None:
        """Set a drone's errors (7,) at the beginning, for derivatives near the truth."""
        self.activate(drone)
        self.joint.mean[:COUNT] = errors

    def platforms(self) -> tuple[Array, Array]:
        """Return all drones' errors (7 N,) and their covariance, in the drones' order."""
        mean, P = self.ordered()
        own = slice(COUNT * len(self.bases))
        return mean[own], P[own, own]

    def ordered(self) -> tuple[Array, Array]:
        """Return mean and covariance of everything: all drones' errors in their order, robots."""
        mean, P, order = self.whole()
        size = len(self.joint.mean)
        firsts = [0, *(size + COUNT * k for k in range(len(order) - 1))]
        places = [firsts[order.index(drone)] + np.arange(COUNT) for drone in sorted(order)]
        every = np.concatenate([*places, np.arange(COUNT, size)])
        return mean[every], P[np.ix_(every, every)]

    def prior(self, stationary: list[Array]) -> Array:
        """Return the prior covariance of all drones' errors (7 N, 7 N), in the drones' order.

        Args:
            stationary: (7, 7) of each drone.
        """
        return joint_prior(stationary, self._share)

    def whole(self) -> tuple[Array, Array, list[int]]:
        """Return mean and covariance of everything, and the order of the drones' blocks in it.

        The active drone's errors come first, then the robots, then the other drones.
        """
        mean = np.concatenate([self.joint.mean, self._mean])
        P = np.block([[self.joint.covariance, self._cross], [self._cross.T, self._own]])
        return mean, P, [self.active, *self._others]

    def activate(self, drone: int) -> None:
        """Make another drone's errors part of the active `JointState`."""
        if drone == self.active:
            return
        own, joint = self._place(drone), self.joint
        mean, P, _ = self.whole()
        size = len(joint.mean)
        order = np.arange(len(mean))
        order[:COUNT], order[size:][own] = order[size:][own].copy(), order[:COUNT].copy()
        mean, P = mean[order], P[np.ix_(order, order)]
        joint.mean, self._mean = mean[:size].copy(), mean[size:].copy()
        joint.covariance, self._cross = P[:size, :size].copy(), P[:size, size:].copy()
        self._own = P[size:, size:].copy()
        self._others[self._others.index(drone)] = self.active
        self.active = drone
        joint.view = None

    def predict(
        self, seconds: float, keep: list[Array], stationary: list[Array], motion: MotionModel
    ) -> None:
        """Predict to a later time.

        Args:
            seconds: length of the step, s.
            keep: (7,) of each drone, `PlatformModel.decay` of this time.
            stationary: (7, 7) of each drone.
            motion: motion model of the robots.
        """
        if seconds <= 0.0:
            return
        joint, others, n = self.joint, self._others, len(self.joint)
        first = keep[self.active]
        if others:
            kept = np.concatenate([keep[drone] for drone in others])
            _, between, own = self._prior(stationary)
            both = first[:, None] * kept
            cross = self._cross
            cross[:COUNT] = both * cross[:COUNT] + (1.0 - both) * between
            if n:
                strength = joint.manoeuvre_noise.strength
                reach, slowed, _ = joint.motion(motion).step(seconds, joint.unseen, strength)
                robots = cross[COUNT:].reshape(n, 4, -1)
                robots[:, :2] += reach[:, None, None] * robots[:, 2:]
                if slowed is not None:
                    robots[:, 2:] *= slowed[:, None, None]
                cross[COUNT:] *= kept
            self._mean *= kept
            both = kept[:, None] * kept
            self._own = both * self._own + (1.0 - both) * own
        self._move_bases(seconds, motion)
        joint.predict(seconds, first, stationary[self.active], motion)

    def _move_bases(self, seconds: float, motion: MotionModel) -> None:
        """Let derivatives move with the robots' velocities, as `JointState.predict` does."""
        if not len(self.joint):
            return
        strength = self.joint.manoeuvre_noise.strength
        each = self.joint.motion(motion)
        reach, slowed, _ = each.step(seconds, self.joint.unseen, strength)
        self._by_pose[:, :2] += reach[:, None, None] * self._by_pose[:, 2:]
        if slowed is not None:
            self._by_pose[:, 2:] *= slowed[:, None, None]

    def look(self, drone: int, sight: CameraView) -> None:
        """Make a drone active and take derivatives at the camera of its image.

        Before that each robot's covariance is carried along with its estimate, as the camera sees
        it that measured it last (see `linearization`). Robots are where the drone's clock has them
        until `settle` (see `clocks`).

        Args:
            drone: its number.
            sight: the image's camera.
        """
        if self._others:
            self._moves = moving(self.joint, self._moves)
        for other in {*self.seen_by.tolist()} - {drone}:
            self.activate(other)
            self._carry(other)
        self.activate(drone)
        self._carry(drone)
        self._show()
        joint, base = self.joint, self.bases[drone]
        joint.camera, joint.view = np.full(3, np.nan), None  # carried already
        relinearize(joint, sight)
        base.camera, base.by_errors = joint.camera.copy(), sight.by_errors
        mine = self.seen_by == drone
        self._by_pose[mine] = joint.by_pose[mine]

    @property
    def _velocities(self) -> Array:
        """(n, 2) of the robots that surely move, 0 of others, m/s."""
        found: Array = self.joint.robots[:, 2:] * self._moves[:, None]
        return found

    def _show(self) -> None:
        """Bring the robots to where the active drone's clock has them."""
        joint = self.joint
        if not self._others or joint.covariance[LATENCY, LATENCY] <= 0.0:
            return
        if not len(joint):
            return
        clock, velocities = float(joint.mean[LATENCY]), self._velocities
        joint.robots[:, :2] -= clock * velocities
        self._shown = clock, velocities
        self._by_clock(-1.0)

    def settle(self) -> None:
        """Bring the robots back to the fleet's time, after the updates of an image."""
        if self._shown is None:
            return
        self._by_clock(1.0)
        joint = self.joint
        joint.robots[:, :2] += float(joint.mean[LATENCY]) * self._velocities
        self._shown = None

    def _by_clock(self, sign: float) -> None:
        """Let positions' errors change by those of velocities and the active drone's clock."""
        assert self._shown is not None  # noqa: S101 - its callers set it
        clock, velocities = self._shown
        P, n = self.joint.covariance, len(velocities)
        for rows in (P, self._cross):
            down = rows[COUNT:].reshape(n, 4, -1)
            down[:, :2] += sign * (clock * down[:, 2:] + velocities[..., None] * rows[LATENCY])
        across, by_clock = P[:, COUNT:].reshape(-1, n, 4), P[:, LATENCY, None]
        for axis in (0, 1):
            more = clock * across[:, :, axis + 2] + by_clock * velocities[:, axis]
            across[:, :, axis] += sign * more

    def _carry(self, drone: int) -> None:
        """Carry the covariance of the robots that the active drone measured last."""
        mine, base, joint = self.seen_by == drone, self.bases[drone], self.joint
        if not mine.any():
            return
        now = seen_from(joint, base.camera)
        change = np.zeros((len(joint), 4, COUNT))
        # What it saw at its own time is elsewhere at the fleet's by its clock and the velocity.
        change[mine, :2, LATENCY] = self._velocities[mine] - self._moving[mine]
        self._moving[mine] = self._velocities[mine]
        mine &= ~np.isnan(self._by_pose[:, 0, 0])
        change[mine] += (now[mine] - self._by_pose[mine]) @ base.by_errors
        joint.carry(change)
        self._cross[COUNT:] += change.reshape(-1, COUNT) @ self._cross[:COUNT]
        self._by_pose[mine] = now[mine]

    def correct(
        self,
        slots: Indices,
        pixels: Array,
        sight: CameraView,
        model: PlatformModel,
        fastest: float = np.inf,
        level: float = 1.0,
    ) -> Outcome:
        """Update with pixels of the active drone's image, after `look`; see `update.correct`."""
        joint = self.joint
        before = joint.mean
        P = joint.covariance.copy() if self._others else joint.covariance
        outcome = correct(joint, slots, pixels, sight, model, fastest, level)
        used = outcome.slots
        self.seen_by[used] = self.active
        self._by_pose[used] = joint.by_pose[used]
        if self._shown is not None:
            self._moving[used] = self._shown[1][used]
        if not self._others or not len(used):
            return outcome
        root = np.linalg.cholesky(outcome.spread)
        by_active = dtrsm(1.0, root, _observed(outcome.linear, used, P), lower=1)
        by_others = dtrsm(1.0, root, _observed(outcome.linear, used, self._cross), lower=1)
        self._pass_on(by_active, by_others, joint.mean - before)
        joint.covariance[LATENCY, LATENCY] -= by_active[:, LATENCY] @ by_active[:, LATENCY]
        return outcome

    def _pass_on(self, by_active: Array, by_others: Array, moved: Array) -> None:
        """Update the other drones after an update of the active part.

        Args:
            by_active: (m, d) covariance of the whitened innovation with the active part.
            by_others: (m, k) the same with the other drones' errors.
            moved: (d,) by how much the active part's mean was corrected.
        """
        known = np.arange(len(moved)) != LATENCY  # only considered by `update.correct`
        white = np.linalg.lstsq(by_active[:, known].T, moved[known], rcond=None)[0]
        self.joint.mean[LATENCY] += white @ by_active[:, LATENCY]
        self._mean += white @ by_others
        self._cross -= by_active.T @ by_others
        self._own -= by_others.T @ by_others

    def begin(
        self, rows: Indices, pixels: Array, sight: CameraView, model: PlatformModel, speed: float,
        own: Array | None = None, level: float = 1.0,
    ) -> None:  # fmt: skip
        """Begin robots from boxes of the active drone's image, after `look`.

        Args:
            rows: (m,) their numbers.
            pixels: (m, 2) centres of the boxes.
            sight: the image's camera.
            model: white noise of pose and boxes.
            speed: one sigma of the unknown velocity, each axis, m/s.
            own: (2, m) accelerations and speed sigmas of their classes, NaN for the defaults.
            level: factor by which white noise is larger than stated.
        """
        joint = self.joint
        rays = sight.camera.rays(pixels)[0] @ FLU_FROM_OPTICAL.T
        places, by_errors = relinearize(joint, sight, rays)
        linear = linearise(sight, joint.mean[:COUNT], places)
        self.append(rows, places, by_errors, white_on_water(linear, model, level), speed, own)

    def append(
        self, rows: Indices, places: Array, by_errors: Array, white: Array, speed: float,
        own: Array | None = None,
    ) -> None:  # fmt: skip
        """Add robots that the active drone sees; see `StateArrays.add`."""
        m, joint = len(rows), self.joint
        joint.add(rows, places, by_errors, white, speed, own)
        through = np.zeros((m, 4, COUNT))
        through[:, :2] = by_errors
        robots = through.reshape(-1, COUNT) @ self._cross[:COUNT]
        self._cross = np.concatenate([self._cross, robots])
        self.seen_by = np.concatenate([self.seen_by, np.full(m, self.active, np.intp)])
        fresh = np.full((m, 4, POSE_COUNT), np.nan)  # nothing to carry before their next image
        self._by_pose = np.concatenate([self._by_pose, fresh])
        self._moving = np.concatenate([self._moving, np.zeros((m, 2))])
        self._moves = np.concatenate([self._moves, np.zeros(m, np.bool_)])
        if self._shown is not None:
            clock, velocities = self._shown
            self._shown = clock, np.concatenate([velocities, np.zeros((m, 2))])

    def linearise_at(self, drone: int, positions: Array) -> None:
        """Make a drone active and set the estimate, for derivatives at the truth of its image.

        Args:
            drone: its number.
            positions: (n, 2) true East, North by `joint.rows`, m; errors are 0.
        """
        self.activate(drone)
        joint = self.joint
        joint.mean[:], self._mean[:] = 0.0, 0.0
        joint.robots[:, :2] = positions[joint.rows]
        joint.camera[:], joint.view = np.nan, None  # nothing is carried

    def drop(self, slots: Indices) -> None:
        """Remove the robots at some indices of `joint.rows`."""
        kept = np.ones(len(self.joint), dtype=np.bool_)
        kept[slots] = False
        self.joint.drop(slots)
        self._cross = self._cross[np.concatenate([np.ones(COUNT, np.bool_), np.repeat(kept, 4)])]
        self.seen_by, self._by_pose = self.seen_by[kept], self._by_pose[kept]
        self._moving, self._moves = self._moving[kept], self._moves[kept]
        if self._shown is not None:
            self._shown = self._shown[0], self._shown[1][kept]

    def apart(self, first: int, second: int, sigma: float) -> float:
        """Return the squared Mahalanobis distance of two robots; see `tie`."""
        joint, k = self.joint, COUNT + 4 * np.array([first, second])
        offset = joint.mean[k[0] : k[0] + 2] - joint.mean[k[1] : k[1] + 2]
        rows = joint.covariance[k[0] : k[0] + 2] - joint.covariance[k[1] : k[1] + 2]
        spread = rows[:, k[0] : k[0] + 2] - rows[:, k[1] : k[1] + 2] + sigma**2 * np.eye(2)
        return float(offset @ np.linalg.solve(spread, offset))

    def tie(self, first: int, second: int, sigma: float) -> None:
        """Condition on two robots having the same position; see `JointState.tie`."""
        joint = self.joint
        a, b = COUNT + 4 * first, COUNT + 4 * second
        apart = joint.covariance[a : a + 2] - joint.covariance[b : b + 2]
        by_others = self._cross[a : a + 2] - self._cross[b : b + 2]
        spread = apart[:, a : a + 2] - apart[:, b : b + 2] + sigma**2 * np.eye(2)
        offset = joint.mean[a : a + 2] - joint.mean[b : b + 2]
        joint.tie(first, second, sigma)
        root = np.linalg.cholesky(spread)
        by_active = np.linalg.solve(root, apart)
        by_others = np.linalg.solve(root, by_others)
        self._mean -= np.linalg.solve(root, offset) @ by_others
        self._cross -= by_active.T @ by_others
        self._own -= by_others.T @ by_others

    def forget_gnss(self, drone: int, stationary: list[Array]) -> None:
        """Reset a receiver's offset, which has jumped, to what the other receivers tell of it.

        Args:
            drone: its number.
            stationary: (7, 7) prior covariance of each drone's errors.
        """
        self.activate(drone)
        active, between, own = self._prior(stationary)
        joint, others = self.joint, np.arange(len(self._mean)) % COUNT < GNSS.stop
        rest = own[np.ix_(others, others)]
        by_others = between[GNSS][:, others] @ np.linalg.pinv(rest, hermitian=True)
        joint.mean[GNSS] = by_others @ self._mean[others]
        with_joint = by_others @ self._cross[:, others].T
        with_others = by_others @ self._own[others]
        joint.covariance[GNSS], joint.covariance[:, GNSS] = with_joint, with_joint.T
        unknown = active[GNSS, GNSS] - by_others @ rest @ by_others.T
        told = by_others @ self._own[np.ix_(others, others)] @ by_others.T
        joint.covariance[GNSS, GNSS] = unknown + told
        self._cross[GNSS] = with_others

    def _place(self, drone: int) -> slice:
        """Return where the errors of a drone that is not active are among the others'."""
        k = COUNT * self._others.index(drone)
        return slice(k, k + COUNT)

    def _prior(self, stationary: list[Array]) -> tuple[Array, Array, Array]:
        """Return the prior covariance of the active drone, with the others, and of these."""
        order = [stationary[drone] for drone in (self.active, *self._others)]
        whole = joint_prior(order, self._share)
        return whole[:COUNT, :COUNT], whole[:COUNT, COUNT:], whole[COUNT:, COUNT:]


def seen_from(joint: JointState, camera: Array) -> Array:
    """Return `state_jacobian` (n, 4, 6) of all robots seen from a camera position (3,), m.

    The active drone's height correction is contained in it, as in `relinearize`.
    """
    points = on_water_surface(joint.robots[:, :2])
    points[:, 2] -= joint.mean[2]
    return state_jacobian(np.concatenate([points - camera, joint.robots[:, 2:]], axis=1))


def moving(joint: JointState, before: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which robots (n,) surely move.

    One that stays would tell of a clock by the noise of its estimated velocity.

    Args:
        joint: their state.
        before: (n,) which did; they do until they stand.
    """
    speeds = np.sqrt(np.square(joint.robots[:, 2:]).sum(axis=1))
    sigmas = np.sqrt(joint.covariance.diagonal()[COUNT:].reshape(-1, 4)[:, 2:].sum(axis=1))
    begins = (speeds > TUNING.moves_mps) & (speeds > TUNING.moves_sigmas * sigmas)
    found: NDArray[np.bool_] = begins | (before & (speeds > TUNING.stands_mps))
    return found


def white_on_water(linear: Linear, model: PlatformModel, level: float = 1.0) -> Array:
    """Return covariances (m, 2, 2) of positions that white noise of pose and boxes causes, m²."""
    metres = np.linalg.inv(linear.by_place)
    by_pose = metres @ linear.by_pose
    white: Array = (by_pose * model.white) @ by_pose.swapaxes(1, 2)
    return level * (white + model.pixel * metres @ metres.swapaxes(1, 2))


def _observed(linear: Linear, slots: Indices, with_state: Array) -> Array:
    """Return the covariance (2 m, k) of pixels with something.

    Args:
        linear: m robots' pixels.
        slots: (m,) these robots.
        with_state: (d, k) covariance of the active part with it.
    """
    m = len(slots)
    product: Array = linear.by_platform.reshape(2 * m, COUNT) @ with_state[:COUNT]
    robots = with_state[COUNT:].reshape(-1, 4, with_state.shape[1])[slots, :2]
    product += (linear.by_place @ robots).reshape(2 * m, -1)
    return product
