# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A new calibration while robots are tracked: their state becomes what it would be with it.

The filter estimates corrections e to the calibrated measurements, with a prior of zero mean and
covariance C. A calibration that is larger by d states that the correction to the former one has the
mean d. A prior with another mean multiplies the posterior by exp(d' C⁻¹ e) up to a constant, which
leaves every covariance as it is and moves every mean, of the robots too, by its covariance with e:

    mean += P[:, e] C⁻¹ d        and then, since corrections refer to the new calibration,  e -= d

This is exact for constant errors and a linear measurement; the change is applied in small steps,
between which the derivatives follow the robots. Its limits are plain: of an error of which nothing
is known (P = C) e stays, and robots move as the new calibration says; one known exactly (P = 0) was
never the calibration's but the sum of both, so that e takes up the difference and no robot moves.

What the filter holds to be exact (C = 0: the latency, by default) and what it does not estimate at
all (the focal length) leaves no covariance, and other errors have followed it. Robots in the last
image then move as it would show them; for the others, seen from elsewhere, the size of such a move
is added to their covariance; and with the next boxes platform and robots begin again from their
priors (`restore_priors`), under their labels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.linearization import CameraView, by_errors, relinearize
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.models.measurement_model import on_water, pose_by_errors, state_jacobian
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, HEADING, HEIGHT, LATENCY

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecalibrationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    step_turn_rad: float = math.radians(0.5)
    """Largest change of an angle between two linearisations, rad: an arc leaves its tangent by 1 mm
    at 30 m."""
    step_share: float = 0.01
    """Largest change of the height between two linearisations, as a share of it. Likewise."""
    flown_mps: float = 10.0
    """One sigma of the speed at which a robot out of view was last flown over, m/s. Judged: drones
    seldom film faster than 20 m/s."""


TUNING = RecalibrationTuning()

FOLLOWING = slice(HEIGHT, LATENCY)
"""Errors that follow a wrong latency or focal length: height, angles, the deviation."""


@dataclass(frozen=True)
class CalibrationChange:
    """What a new configuration adds to the calibration of the former one.

    Attributes:
        errors: (9,) by the platform's errors (`platform_model.PLATFORM`): m, rad, s.
        focal: ratio of the new focal length to the former one.
    """

    errors: Array = field(default_factory=lambda: np.zeros(COUNT))
    focal: float = 1.0

    @staticmethod
    def between(former: EstimatorConfig, new: EstimatorConfig) -> CalibrationChange:
        """Return the change from one configuration to another."""
        before, after = former.calibration, new.calibration
        errors = np.zeros(COUNT)
        errors[HEIGHT] = after.height_m - before.height_m
        for i, name in enumerate(("gimbal_roll_deg", "gimbal_pitch_deg", "heading_deg")):
            errors[ANGLES.start + i] = math.radians(getattr(after, name) - getattr(before, name))
        errors[HEADING] = math.remainder(errors[HEADING], 2.0 * math.pi)
        errors[LATENCY] = new.camera.latency_s - former.camera.latency_s
        return CalibrationChange(errors, after.focal_scale / before.focal_scale)

    def modelled(self, prior: Array) -> bool:
        """Return whether the filter estimates all errors that change.

        Args:
            prior: (9, 9) their covariance when nothing is known; 0 for what it takes to be exact.
        """
        return self.focal == 1.0 and not self.errors[prior.diagonal() == 0.0].any()

    def __bool__(self) -> bool:
        return bool(self.errors.any()) or self.focal != 1.0


def recalibrate(
    joint: JointState, change: CalibrationChange, prior: Array, sight: CameraView, searched: bool
) -> None:
    """Move robots and platform to where they would be with another calibration.

    Args:
        joint: changed in place.
        change: of the calibration.
        prior: (9, 9) covariance of the platform's errors when nothing is known.
        sight: the last image, with the former calibration.
        searched: whether the latency is estimated elsewhere (`LatencySearch`), which tells its
            correction before the next image; until then only the sum is kept.
    """
    relinearize(joint, sight)
    if change.focal != 1.0 and len(joint):
        _rescale(joint, change.focal, sight)
    errors, known = change.errors.copy(), prior.diagonal() > 0.0
    if searched:
        joint.mean[LATENCY] -= errors[LATENCY]
        errors[LATENCY] = 0.0
    for _ in range(steps := _steps(errors, float(sight.measured.position[2]))):
        _move(joint, np.where(known, errors, 0.0) / steps, prior)
    joint.mean[:COUNT] -= np.where(known, errors, 0.0)
    joint.camera[2] += errors[HEIGHT]
    if len(joint):
        _move_unmodelled(joint, np.where(known, 0.0, errors), sight)
    joint.view = None


def likelier(joint: JointState, change: CalibrationChange, prior: Array) -> float:
    """Return the log of how much likelier all images become by a change of modelled errors, nats.

    The posterior mean of the ratio of the new prior to the former one: E[exp(d'C⁻¹e - d'C⁻¹d/2)].

    Args:
        joint: a law, before the change.
        change: of the calibration.
        prior: (9, 9) covariance of the platform's errors when nothing is known.
    """
    moved = np.flatnonzero(change.errors)
    shift = change.errors[moved]
    told = shift / _scales(joint, moved, prior)
    of_these = joint.covariance[np.ix_(moved, moved)]
    return float(told @ (joint.mean[moved] + 0.5 * of_these @ told - 0.5 * shift))


def restore_priors(joint: JointState, slots: Indices, prior: Array, speed: Array | float) -> None:
    """Forget what images told of the platform by a calibration without covariance.

    Its height and angles have followed a wrong latency or focal length, and so have the robots: the
    platform's begin at their prior, and robots at their next boxes. The receiver's offset stays,
    with what robots out of view share of it, so that none of them counts twice.

    Args:
        joint: changed in place; relinearised at the present image.
        slots: (m,) indices in `rows` of the robots with a box in this image.
        prior: (9, 9) covariance of the platform's errors when nothing is known.
        speed: one sigma of these robots' unknown velocities, each axis, m/s.
    """
    P = joint.covariance
    joint.mean[FOLLOWING] = 0.0
    P[FOLLOWING] = P[:, FOLLOWING] = 0.0
    P[FOLLOWING, FOLLOWING] = prior[FOLLOWING, FOLLOWING]
    joint.forget_robots(slots, speed)


def _scales(joint: JointState, moved: Indices, prior: Array) -> Array:
    """Return the variances of some errors when nothing is known, at least those of the law."""
    scales: Array = np.maximum(prior.diagonal(), joint.covariance.diagonal()[:COUNT])[moved]
    return scales


def _steps(errors: Array, height: float) -> int:
    angle = float(np.abs(errors[ANGLES]).max()) / TUNING.step_turn_rad
    share = abs(float(errors[HEIGHT])) / (TUNING.step_share * max(height, 1.0))
    return max(1, math.ceil(max(angle, share)))


def _move(joint: JointState, errors: Array, prior: Array) -> None:
    """Apply a small change of modelled errors (9,), with the corrections still to the former ones.

    An error that a fault test has widened beyond its prior moves no farther than by the prior.
    """
    moved = np.flatnonzero(errors)
    P = joint.covariance
    shift = P[:, moved] @ (errors[moved] / _scales(joint, moved, prior))
    joint.mean += shift
    n = len(joint)
    if not n:
        return
    before = joint.by_errors
    turn = np.array([0.0, 0.0, before[5, :LATENCY] @ shift[:LATENCY]])
    # axes turn with the camera's heading
    axes = pose_by_errors(rotation_matrix(turn) @ before[3:, ANGLES], -before[:, LATENCY])
    points = on_water_surface(joint.robots[:, :2])
    points[:, 2] -= joint.mean[HEIGHT]
    by_pose = state_jacobian(np.hstack([points - joint.camera, joint.robots[:, 2:]]))
    joint.carry(by_pose @ axes - joint.by_pose @ joint.by_errors)
    joint.by_pose, joint.by_errors = by_pose, axes


def _move_unmodelled(joint: JointState, errors: Array, sight: CameraView) -> None:
    """Apply changes (9,) of errors that the filter takes to be exact."""
    if not errors.any():
        return
    shift = by_errors(joint, np.arange(len(joint))) @ errors
    late = abs(float(errors[LATENCY])) * max(
        TUNING.flown_mps, float(np.linalg.norm(sight.rates[:3]))
    )
    _shift(joint, shift, np.hypot(np.linalg.norm(shift, axis=1), late))


def _rescale(joint: JointState, focal: float, sight: CameraView) -> None:
    """Move robots to where their pixels lie with another focal length.

    A wrong one feigns velocities while the camera moves, so they become less certain.
    """
    pose = sight.pose(joint.mean[:COUNT])
    offsets = on_water_surface(joint.robots[:, :2]) - pose.position
    rays = offsets @ pose.rotation
    ahead = rays[:, 0] > 0.0
    rays[:, 1:] /= focal
    places = on_water(pose, rays @ pose.rotation.T)
    shift = np.where(ahead[:, None] & np.isfinite(places), places - joint.robots[:, :2], 0.0)
    unsure = abs(1.0 - 1.0 / focal)
    far = np.maximum(np.linalg.norm(shift, axis=1), unsure * np.linalg.norm(offsets, axis=1))
    _shift(joint, shift, far)
    feigned = unsure * float(np.linalg.norm(sight.rates[:3]))
    own = COUNT + 4 * np.arange(len(joint))[:, None] + np.array([2, 3])
    joint.covariance[own, own] += feigned**2


def _shift(joint: JointState, shift: Array, unsure: Array) -> None:
    """Move robots in the last image by (n, 2), and widen the others by (n,), one sigma, m.

    Robots in the last image had followed the wrong value with a lag, so they are widened by the
    size of their own move; their next boxes replace that.
    """
    seen = joint.unseen == 0.0
    joint.robots[seen, :2] += shift[seen]
    wider = np.where(seen, np.linalg.norm(shift, axis=1), unsure)
    own = COUNT + 4 * np.arange(len(joint))[:, None] + np.arange(2)
    joint.covariance[own, own] += np.square(wider)[:, None]
