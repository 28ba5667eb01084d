# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Posterior Cramér-Rao bound of a flight, or of several together: the least covariance.

Recursion of Tichavský, Muravchik and Nehorai (1998, IEEE Trans. Signal Processing 46(5)) with the
filter's own states and dynamics, all derivatives on the true trajectory. With additive Gaussian
noise and linear dynamics it is the covariance recursion of a Kalman filter linearised at the truth,
so it is computed by the filter's own prediction and update. For one realised trajectory it bounds
the mean square error over all noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.predicted_pixels import Linear, linearise
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.fleet.shared_state import SharedState, white_on_water
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_vector
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrueFrame:
    """The truth of one image.

    Attributes:
        pose: of the camera; its stamp is the time of the scene.
        positions: (n, 2) East, North of all robots in `map`, m.
        seen: (n,) True for those with a box.
    """

    pose: CameraPose
    positions: Array
    seen: NDArray[np.bool_]


@dataclass(frozen=True)
class TrueDrone:
    """One of several drones, for `joint_bound`.

    Attributes:
        config: the stated noise and motion.
        camera: lens and image.
        frames: in the order of time; all drones' with the same robots.
    """

    config: EstimatorConfig
    camera: CameraModel
    frames: Sequence[TrueFrame]


def bound(
    config: EstimatorConfig,
    camera: CameraModel,
    frames: Sequence[TrueFrame],
    local: LocalMap,
    known: Mapping[int, float] | None = None,
) -> Array:
    """Return the bounds (images, n, 4, 4) on the robots' covariances; NaN before first seen.

    Args:
        config: the stated noise and motion.
        camera: lens and image.
        frames: in the order of time; all with the same robots.
        local: the frame `map`.
        known: robots that stay and whose places are known: one sigma by robot, each axis, m. The
            error of a survey is one number: each image uses the same law of it.
    """
    return joint_bound([TrueDrone(config, camera, frames)], local, 0.0, known)[0]


def joint_bound(
    drones: Sequence[TrueDrone],
    local: LocalMap,
    share: float,
    known: Mapping[int, float] | None = None,
) -> list[Array]:
    """Return the bounds of several drones together: for each drone as `bound`, at its images.

    Args:
        drones: which see the same robots; the motion of robots is that of the first one's config.
        local: the frame `map`.
        share: part of the variance of the receivers' offsets that is common.
        known: as for `bound`.
    """
    return Recursion(drones, local, share, known).run()


class Recursion:
    """The covariance recursion of several drones; `best_estimate` has its estimates, too.

    Args:
        drones: as for `joint_bound`, as all others.
    """

    def __init__(
        self,
        drones: Sequence[TrueDrone],
        local: LocalMap,
        share: float,
        known: Mapping[int, float] | None = None,
    ) -> None:
        config = drones[0].config
        self.drones, self._known = drones, dict(known or {})
        self.models = [
            PlatformModel(d.config.noise, d.config.gimbal.reference, exact=True) for d in drones
        ]
        self._stationary = [model.stationary(None) for model in self.models]
        self._motion = MotionModel(
            config.noise.value("robot_acceleration"), 0.5 * config.tracks.max_speed
        )
        self._poses = [[MapPose.of(frame.pose, local) for frame in one.frames] for one in drones]
        self.count = max((len(one.frames[0].positions) for one in drones if one.frames), default=0)
        self.state = SharedState(self._stationary, share)

    def run(self) -> list[Array]:
        """Return what `joint_bound` does."""
        stamps = [[frame.pose.stamp_ns * 1e-9 for frame in one.frames] for one in self.drones]
        found = [np.full((len(of), self.count, 4, 4), np.nan) for of in stamps]
        now: float | None = None
        times = [(t, d, k) for d, of in enumerate(stamps) for k, t in enumerate(of)]
        for t, d, k in sorted(times, key=lambda item: item[:2]):
            if now is not None:
                self.predict(t - now)
            now = t
            frame, camera, pose = self.drones[d].frames[k], self.drones[d].camera, self._poses[d][k]
            sight = CameraView.of(camera, pose, _rates(self._poses[d], stamps[d], k), 0.0)
            self.image(d, k, frame, sight)
            joint = self.state.joint
            found[d][k, joint.rows] = _given(joint, self._known)
        return found

    def predict(self, seconds: float) -> None:
        """Predict to the next image."""
        keep = [model.decay(seconds) for model in self.models]
        self.state.predict(seconds, keep, self._stationary, self._motion)

    def image(self, d: int, k: int, frame: TrueFrame, sight: CameraView) -> None:
        """Use the boxes of image k of drone d, its camera at the truth."""
        self.state.linearise_at(d, frame.positions)
        joint = self.state.joint
        slots = np.flatnonzero(frame.seen[joint.rows])
        if len(slots):
            places = joint.robots[slots, :2]
            pixels = linearise(sight, np.zeros(COUNT), places).pixels
            self.update(d, k, slots, pixels, sight)
        new = np.setdiff1d(np.flatnonzero(frame.seen), joint.rows)
        if len(new):
            self.begin(d, k, new, frame.positions[new], sight)

    def update(self, d: int, k: int, slots: Indices, pixels: Array, sight: CameraView) -> Outcome:
        """Update robots with boxes where they are expected, so that no mean changes."""
        del k
        return self.state.correct(slots, pixels, sight, self.models[d])

    def begin(self, d: int, k: int, rows: Indices, places: Array, sight: CameraView) -> Linear:
        """Begin robots seen for the first time; those whose place is known stay."""
        del k
        linear = linearise(sight, np.zeros(COUNT), places)
        metres: Array = np.asarray(np.linalg.inv(linear.by_place), np.float64)
        own = np.where(np.isin(rows, [*self._known]), 0.0, np.nan) * np.ones((2, 1))
        by_errors, white = -metres @ linear.by_platform, white_on_water(linear, self.models[d])
        self.state.append(rows, places, by_errors, white, self._motion.speed_sigma, own)
        return linear


def _given(joint: JointState, known: Mapping[int, float]) -> Array:
    """Return robots' covariances (n, 4, 4) given where some are, of those seen so far."""
    rows = [row for row in joint.rows.tolist() if row in known]
    if not rows:
        return joint.blocks()
    law = PositionLaw.of(joint)
    spread = np.array([known[row] ** 2 * np.eye(2) for row in rows])
    return law.known(rows, joint.robots[np.isin(joint.rows, rows), :2], spread).states()[1]


def _rates(poses: Sequence[MapPose], stamps: Sequence[float], k: int) -> Array:
    """Return the pose's (6,) rates by central differences, m/s and rad/s."""
    a, b = max(k - 1, 0), min(k + 1, len(poses) - 1)
    span = stamps[b] - stamps[a]
    if span <= 0.0:
        return np.zeros(6)
    turn = rotation_vector(poses[b].rotation @ poses[a].rotation.T)
    return np.concatenate([poses[b].position - poses[a].position, turn]) / span
