# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout of the joint Gaussian of the platform's errors and some robots.

State: the platform's errors (`platform_model.PLATFORM`), then east, north, velocity east, velocity
north (m, m/s, in `map`) of each robot. Given the platform's errors robots move independently, but
their full covariance is kept: measurements made while the errors drifted leave correlations that
the present errors do not explain.
"""

from __future__ import annotations

import math
from itertools import count

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.manoeuvre_noise import ManoeuvreNoise
from aerial_gnss_ros.core.faults.rotation_fault import RotationFault
from aerial_gnss_ros.core.faults.velocity_changes import VelocityChanges
from aerial_gnss_ros.core.models.measurement_model import POSE_COUNT
from aerial_gnss_ros.core.models.motion_model import MotionModel, MotionOf
from aerial_gnss_ros.core.models.platform_model import COUNT

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_ALL = slice(None)
_IDS = count()


class StateArrays:
    """The platform's errors and robots together.

    Attributes:
        mean: (9 + 4 n,).
        covariance: (9 + 4 n, 9 + 4 n).
        rows: (n,) rows of these robots in the track table.
        ids: (n,) permanent numbers of the robots: rows change when robots are dropped.
        sway: (n,) 1 where a robot's last two numbers are no velocity but add to its place, see
            `moored_law`; None: nowhere.
        unseen: (n,) time since each was measured, s.
        manoeuvre_noise: process noise of each robot.
        velocity_changes: recent velocity changes of each robot.
        rotation_fault: test for a rotating camera.
        by_pose: (k, 4, 6) `state_jacobian` to which the covariance of the first k robots refers,
            see `linearization`; later ones are new.
        camera: (3,) camera position of that, m; NaN at first.
        by_errors: (6, 9) `pose_by_errors` of that time.
        view: the image of that time.
    """

    def __init__(self, covariance: Array, rotation_fault: RotationFault | None = None) -> None:
        """Start without robots.

        Args:
            covariance: (9, 9) of the platform's errors.
            rotation_fault: of the camera, shared with other blocks.
        """
        self.mean = np.zeros(COUNT)
        self.covariance = covariance.copy()
        self.rows: Indices = np.zeros(0, np.intp)
        self.ids: Indices = np.zeros(0, np.intp)
        self.sway: Array | None = None
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

    def shown(self, slots: Indices | slice, mean: Array | None = None) -> Array:
        """Return apparent positions (m, 2) of robots, by the present state or another one."""
        robots = (self.mean if mean is None else mean)[COUNT:].reshape(-1, 4)[slots]
        places: Array = robots[:, :2]
        return places if self.sway is None else places + self.sway[slots, None] * robots[:, 2:]

    def blocks(self) -> Array:
        """Return the robots' own covariances (n, 4, 4)."""
        n = len(self.rows)
        blocks = self.covariance[COUNT:, COUNT:].reshape(n, 4, n, 4)
        return blocks.diagonal(axis1=0, axis2=2).transpose(2, 0, 1).copy()

    def motion(
        self, default: MotionModel, slots: Indices | slice = _ALL
    ) -> MotionModel | MotionOf[Array]:
        """Return the motion models of some robots.

        Args:
            default: of classes without their own parameters.
            slots: their indices in `rows`.
        """
        own = self.own[:, slots]
        if all(map(math.isnan, own.ravel().tolist())):
            return default
        both = (default.acceleration, default.speed_sigma)
        accelerations, speeds = np.where(np.isnan(own), np.array(both)[:, None], own)
        return MotionOf(accelerations, speeds)

    def positions(self) -> tuple[Array, Array, Array]:
        """Return views of the robots' positions (n, 2) and covariances.

        Their covariances (n, 2, 2), and those with the platform's errors (n, 2, 9).
        """
        n, P = len(self.rows), self.covariance
        own = P[COUNT:, COUNT:].reshape(n, 4, n, 4).diagonal(axis1=0, axis2=2).transpose(2, 0, 1)
        with_platform = P[COUNT:, :COUNT].reshape(n, 4, COUNT)[:, :2]
        return self.mean[COUNT:].reshape(n, 4)[:, :2], own[:, :2, :2], with_platform

    def add(
        self,
        rows: Indices,
        positions: Array,
        by_platform: Array,
        white: Array,
        speed: float,
        own: Array | None = None,
    ) -> None:
        """Initialise robots, each from one measurement through the platform's errors.

        Args:
            rows: (m,) their numbers.
            positions: (m, 2) by the present estimate of the platform's errors, m.
            by_platform: (m, 2, 9) derivatives of these by the platform's errors.
            white: (m, 2, 2) white covariance of the positions, m².
            speed: one sigma of the unknown velocity, each axis, m/s.
            own: (2, m) accelerations and speed sigmas of their classes, NaN for the defaults.
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
        """Add robots with a known distribution given the platform's errors.

        Args:
            rows: (m,) their numbers.
            state: (m, 4) their means by the present estimate of the platform's errors, m, m/s.
            by_platform: (m, 4, 9) derivatives of these by the platform's errors.
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
        self.ids = np.concatenate([self.ids, np.array([next(_IDS) for _ in range(m)], np.intp)])
        self.unseen = np.concatenate([self.unseen, np.zeros(m)])
        self.own = np.concatenate([self.own, np.full((2, m), np.nan)], axis=1)
        self.manoeuvre_noise.add(m)
        self.velocity_changes.add(m)

    def drop(self, slots: Indices) -> None:
        """Remove the robots at some indices of `rows`."""
        kept = np.ones(len(self), dtype=np.bool_)
        kept[slots] = False
        index = np.concatenate([np.ones(COUNT, np.bool_), np.repeat(kept, 4)])
        self.mean = self.mean[index]
        self.covariance = self.covariance[np.ix_(index, index)]
        self.rows, self.unseen = self.rows[kept], self.unseen[kept]
        self.ids = self.ids[kept]
        self.own = self.own[:, kept]
        self.manoeuvre_noise.drop(kept)
        self.velocity_changes.drop(kept)
        self.by_pose = self.by_pose[kept[: len(self.by_pose)]]
