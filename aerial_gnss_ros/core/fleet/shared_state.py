# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Filter of the platform errors of several drones and of the robots that they see.

The active part (see `drone_blocks`) is predicted and updated as that of a single drone. Linear maps
of it apply to its covariances with the other drones, and an update passes on to these by the same
gain. So this is the Kalman filter of all together, and with one drone nothing but its joint filter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dtrsm

from aerial_gnss_ros.core.filter.linearization import CameraView, relinearize
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.predicted_pixels import Linear, linearise
from aerial_gnss_ros.core.filter.state import JointState, of_robots
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.fleet.drone_blocks import DroneBlocks
from aerial_gnss_ros.core.fleet.moving_robots import moving
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.models.measurement_model import POSE_COUNT, state_jacobian
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY, PlatformModel

Array = NDArray[np.float64]


@dataclass
class Base:
    """Where a drone was when its last image was used, and how its errors act on its pose.

    Attributes:
        camera: (3,) position, m; NaN at first.
        by_errors: (6, 9) derivative of the pose by the drone's errors.
    """

    camera: Array
    by_errors: Array


class SharedState(DroneBlocks):
    """Platform errors of several drones, and robots.

    Args:
        stationary: (9, 9) prior covariance of each drone's errors.
        share: prior share of the receivers' variance that is common to all drones.

    Attributes:
        joint: the active drone's errors and the robots.
        active: number of the active drone.
        bases: of each drone.
        seen_by: (n,) number of the drone that measured each robot last.
    """

    def __init__(self, stationary: list[Array], share: float) -> None:
        super().__init__(stationary, share)
        self.bases = [Base(np.full(3, np.nan), np.zeros((POSE_COUNT, COUNT))) for _ in stationary]
        self.seen_by: Indices = np.zeros(0, np.intp)
        self._by_pose = np.zeros((0, 4, POSE_COUNT))
        self._shown: tuple[float, Array] | None = None  # clock and velocities of an image's drone
        self._moves = np.zeros(0, np.bool_)
        self._moving = np.zeros((0, 2))  # velocity to which covariances with its clock refer

    def predict(
        self, seconds: float, keep: list[Array], stationary: list[Array], motion: MotionModel
    ) -> None:
        """Predict to a later time.

        Args:
            seconds: length of the step, s.
            keep: (9,) of each drone, `PlatformModel.decay` of this time.
            stationary: (9, 9) of each drone.
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
        swims = np.ones(n) if self.joint.sway is None else 1.0 - self.joint.sway
        for rows in (P, self._cross):
            down = rows[COUNT:].reshape(n, 4, -1)
            moved = clock * swims[:, None, None] * down[:, 2:]
            down[:, :2] += sign * (moved + velocities[..., None] * rows[LATENCY])
        across, by_clock = P[:, COUNT:].reshape(-1, n, 4), P[:, LATENCY, None]
        for axis in (0, 1):
            more = clock * swims * across[:, :, axis + 2] + by_clock * velocities[:, axis]
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
        alone: bool = False,
    ) -> Outcome:
        """Update with pixels of the active drone's image, after `look`; see `update.correct`."""
        joint = self.joint
        P = joint.covariance.copy() if self._others else joint.covariance
        outcome = correct(joint, slots, pixels, sight, model, fastest, level, alone)
        used = outcome.slots
        self.seen_by[used] = self.active
        self._by_pose[used] = joint.by_pose[used]
        if self._shown is not None:
            self._moving[used] = self._shown[1][used]
        if not self._others or not len(used):
            return outcome
        root = np.linalg.cholesky(outcome.spread)
        sway = np.zeros(len(used)) if joint.sway is None else joint.sway[used]
        by_active = dtrsm(1.0, root, _observed(outcome.linear, used, P, sway), lower=1)
        by_others = dtrsm(1.0, root, _observed(outcome.linear, used, self._cross, sway), lower=1)
        if alone:
            own = of_robots(used)
            self._cross[own] -= by_active[:, own].T @ by_others
            return outcome
        self._pass_on(by_active, by_others, outcome.white)
        joint.covariance[LATENCY, LATENCY] -= by_active[:, LATENCY] @ by_active[:, LATENCY]
        return outcome

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
        self.appended(robots)

    def appended(self, with_others: Array) -> None:
        """Add what is kept of robots beside `joint`, which has them already.

        Args:
            with_others: (4 m, k) their covariance with the errors of the drones not active.
        """
        m = len(with_others) // 4
        self._cross = np.concatenate([self._cross, with_others])
        self.seen_by = np.concatenate([self.seen_by, np.full(m, self.active, np.intp)])
        fresh = np.full((m, 4, POSE_COUNT), np.nan)  # nothing to carry before their next image
        self._by_pose = np.concatenate([self._by_pose, fresh])
        self._moving = np.concatenate([self._moving, np.zeros((m, 2))])
        self._moves = np.concatenate([self._moves, np.zeros(m, np.bool_)])
        if self._shown is not None:
            clock, velocities = self._shown
            self._shown = clock, np.concatenate([velocities, np.zeros((m, 2))])

    def inherit(self, source: SharedState, slot: int) -> None:
        """Let the last robot have what is kept of another state's beside `joint`."""
        self.seen_by[-1], self._by_pose[-1] = source.seen_by[slot], source._by_pose[slot]
        self._moving[-1], self._moves[-1] = source._moving[slot], source._moves[slot]
        if self._shown is not None and source._shown is not None:
            self._shown[1][-1] = source._shown[1][slot]

    def drop(self, slots: Indices) -> None:
        """Remove the robots at some indices of `joint.rows`."""
        kept = np.ones(len(self.joint), dtype=np.bool_)
        kept[slots] = False
        self.joint.drop(slots)
        self.dropped(kept)

    def dropped(self, kept: NDArray[np.bool_]) -> None:
        """Forget the robots that `joint` has forgotten; (n,) mask of the others."""
        self._cross = self._cross[np.concatenate([np.ones(COUNT, np.bool_), np.repeat(kept, 4)])]
        self.seen_by, self._by_pose = self.seen_by[kept], self._by_pose[kept]
        self._moving, self._moves = self._moving[kept], self._moves[kept]
        if self._shown is not None:
            self._shown = self._shown[0], self._shown[1][kept]


def seen_from(joint: JointState, camera: Array) -> Array:
    """Return `state_jacobian` (n, 4, 6) of all robots seen from a camera position (3,), m.

    The active drone's height correction is contained in it, as in `relinearize`.
    """
    points = on_water_surface(joint.robots[:, :2])
    points[:, 2] -= joint.mean[2]
    return state_jacobian(np.concatenate([points - camera, joint.robots[:, 2:]], axis=1))


def white_on_water(linear: Linear, model: PlatformModel, level: float = 1.0) -> Array:
    """Return covariances (m, 2, 2) of positions that white noise of pose and boxes causes, m²."""
    metres = np.linalg.inv(linear.by_place)
    by_pose = metres @ linear.by_pose
    white: Array = (by_pose * model.white) @ by_pose.swapaxes(1, 2)
    return level * (white + model.pixel * metres @ metres.swapaxes(1, 2))


def _observed(linear: Linear, slots: Indices, with_state: Array, sway: Array) -> Array:
    """Return the covariance (2 m, k) of pixels with something.

    Args:
        linear: m robots' pixels.
        slots: (m,) these robots.
        with_state: (d, k) covariance of the active part with it.
        sway: (m,) 1 where a robot's last two numbers add to its place (`StateArrays.sway`).
    """
    m = len(slots)
    product: Array = linear.by_platform.reshape(2 * m, COUNT) @ with_state[:COUNT]
    states = with_state[COUNT:].reshape(-1, 4, with_state.shape[1])[slots]
    robots = states[:, :2] + sway[:, None, None] * states[:, 2:]
    product += (linear.by_place @ robots).reshape(2 * m, -1)
    return product
