# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Linearisation of the measurement by the platform's errors, without spurious information.

Derivatives at the newest estimate jitter with the noise of that very image; the products of the two
have a mean, and over hundreds of images they are mistaken for information about height and tilt
that nobody has (docs/results/consistency.md has the figures). Two measures prevent it:

The derivative by a robot's position is part of the robot's own state: a height error of 1 % makes a
robot 1 % farther and 1 % faster, wherever it is. So when a robot's estimate moves, by prediction or
correction, its covariance with the platform is carried along (`JointState.carry`), and nothing is
learnt. Only a moving camera is informative: what is carried is the change of the derivative with
the robot's position, seen from the previous camera position. In other words, robots are kept as the
camera sees them, so that unobservable errors stay unobservable.

The camera's own position is predicted from earlier images (`CameraMotion`), without the noise of
the present one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.measurement_model import (
    on_water,
    pose_by_errors,
    pose_jacobian,
    state_jacobian,
)
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, LATENCY

Array = NDArray[np.float64]

_NO_RAYS, _NOWHERE = np.zeros((0, 3)), np.zeros((0, 2))
_NO_CHANGE = np.zeros((0, 2, COUNT))


@dataclass(frozen=True)
class CameraView:
    """Camera model, pose and derivatives of one image for the filter.

    Attributes:
        camera: lens and image.
        measured: the pose from telemetry.
        foretold: (3,) camera position predicted from earlier images, m.
        axes: (3, 3) of roll, pitch and heading errors, of the foretold pose.
        rates: (6,) of the pose, m/s and rad/s.
        by_errors: (6, 9) `pose_by_errors` of these.
        applied: latency already contained in the pose, beyond the configured one, s.
        bend: (6,) variances of the pose, as `rates`, that interpolation of telemetry and an unknown
            latency add to the white noise, the latter beyond what goes with the rates.
    """

    camera: CameraModel
    measured: MapPose
    foretold: Array
    axes: Array
    rates: Array
    by_errors: Array
    applied: float = 0.0
    bend: Array = field(default_factory=lambda: np.zeros(6))
    _poses: dict[bytes, MapPose] = field(default_factory=dict, repr=False)

    @staticmethod
    def of(
        camera: CameraModel,
        measured: MapPose,
        rates: Array,
        applied: float,
        foretold: MapPose | None = None,
        unsure_s: float = 0.0,
        interpolation: Array | None = None,
    ) -> CameraView:
        """Return the view with its axes; without a foretold pose the measured one is used.

        The variances of `interpolation` (6,) are added to `bend`.

        A camera that circles with acceleration a = ω v deviates by a t²/2 from the straight line of
        its rates: for a latency error of sigma `unsure_s` that has the variance 3/4 a² sigma⁴.
        """
        pose = foretold or measured
        axes = error_axes(pose.rotation)
        by_errors = pose_by_errors(axes, rates)
        bend = np.zeros(6) if interpolation is None else interpolation.copy()
        if unsure_s:
            bend[:3] += 0.75 * unsure_s**4 * np.square(np.cross(rates[3:], rates[:3]))
        return CameraView(camera, measured, pose.position, axes, rates, by_errors, applied, bend)

    def rays(self, points: Array) -> Array:
        """Return the rays (m, 3), of any length, to points (m, 3) in the camera's measured axes."""
        rays: Array = (points - self.measured.position) @ self.measured.rotation
        return rays

    def pose(self, errors: Array) -> MapPose:
        """Return the pose corrected by the platform's errors (9,); the last result is cached."""
        key = errors.tobytes()
        if key not in self._poses:
            self._poses.clear()
            pose = self.measured.corrected(self.by_errors[:, :LATENCY] @ errors[:LATENCY])
            late = float(errors[LATENCY]) - self.applied
            self._poses[key] = pose.corrected(-late * self.rates) if late else pose
        return self._poses[key]

    def standpoint(self, errors: Array) -> Array:
        """Return the foretold place (3,) with the platform's errors (9,) but height taken out."""
        east, north = errors[:2].tolist()
        x, y, z = self.foretold.tolist()
        late = float(errors[LATENCY]) - self.applied
        place = np.array([x + east, y + north, z])
        return place - late * self.rates[:3] if late else place


def relinearize(
    joint: JointState, sight: CameraView, rays: Array = _NO_RAYS
) -> tuple[Array, Array]:
    """Carry the covariance along with robots that moved, and change to the new camera position.

    Called once per image, before its measurements are used.

    Args:
        joint: changed in place.
        sight: the camera.
        rays: (m, 3) of detections, see `CameraView.rays`.

    Returns:
        Their positions on the water (m, 2) by the estimated platform errors, and the derivatives by
        the errors (m, 2, 9).
    """
    camera, places, moved = sight.standpoint(joint.mean[:COUNT]), _NOWHERE, _NO_CHANGE
    if len(rays):
        pose = sight.pose(joint.mean[:COUNT])
        places = on_water(pose, rays @ pose.rotation.T)
    if joint.view is sight:
        return places, by_platform(joint, places) if len(rays) else moved
    robots, k = joint.mean[COUNT:].reshape(-1, 4), len(joint.by_pose)
    n = len(robots)
    if n or len(places):
        points = on_water_surface(np.concatenate([robots[:, :2], places]))
        points[:, 2] -= joint.mean[2]
        # From the previous and the present camera position: offsets and velocities.
        states = np.zeros((k + len(points), 5))
        states[:k, :3], states[k:, :3] = points[:k] - joint.camera, points - camera
        states[:k, 3:], states[k : k + n, 3:] = robots[:k, 2:], robots[:, 2:]
        both = state_jacobian(states)
        if k and not math.isnan(joint.camera[0]):
            joint.carry((both[:k] - joint.by_pose) @ joint.by_errors)
        joint.by_pose, moved = both[k : k + n], both[k + n :, :2] @ sight.by_errors
    joint.camera, joint.by_errors, joint.view = camera, sight.by_errors, sight
    return places, moved


def by_platform(joint: JointState, places: Array) -> Array:
    """Return derivatives (m, 2, 9) of positions (m, 2) on the water by the platform's errors.

    At the camera position of `relinearize`.
    """
    points = on_water_surface(places)
    points[:, 2] -= joint.mean[2]
    moved: Array = pose_jacobian(points - joint.camera) @ joint.by_errors
    return moved


def by_angles(joint: JointState, slots: Indices) -> Array:
    """Return derivatives (m, 2, 3) of robots' positions by the platform's angles, m/rad.

    At the camera position of `relinearize`, also for robots initialised from this image.
    """
    return by_errors(joint, slots)[:, :, ANGLES]


def by_errors(joint: JointState, slots: Indices) -> Array:
    """Return derivatives (m, 2, 9) of robots' positions by the platform's errors.

    At the camera position of `relinearize`, also for robots initialised from this image.
    """
    if len(slots) and int(slots.max()) >= len(joint.by_pose):
        return by_platform(joint, joint.robots[slots, :2])
    moved: Array = joint.by_pose[slots, :2] @ joint.by_errors
    return moved
