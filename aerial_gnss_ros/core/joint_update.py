# SPDX-License-Identifier: Apache-2.0
"""What one image tells of the platform's errors and of the robots in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.joint_geometry import (
    MapPose,
    level_axes,
    platform_jacobian,
    pose_jacobian,
    water_points,
)
from aerial_gnss_ros.core.joint_platform import COUNT, PlatformModel
from aerial_gnss_ros.core.joint_state import Indices, Joint

Array = NDArray[np.float64]

HUBER = 2.8
"""Normalised residual (planar) from which a box counts less: 2 % of the good ones."""

RELINEARISE = 0.02
"""A robot that a correction moves by this share of its distance is corrected from there anew."""

MAX_ITERATIONS = 3


@dataclass(frozen=True)
class Sight:
    """One image's camera, ready for the filter.

    Attributes:
        camera: lens and image.
        measured: the pose as telemetry has it.
        smooth: the pose to linearise at, see `smooth_pose`.
        axes: (3, 3) of roll, pitch and heading errors.
        rates: (6,) of the pose, m/s and rad/s.
        applied: latency that the pose already allows for, beyond the configured one, s.
    """

    camera: CameraModel
    measured: MapPose
    smooth: MapPose
    axes: Array
    rates: Array
    applied: float = 0.0

    @staticmethod
    def of(
        camera: CameraModel, measured: MapPose, smooth: MapPose, rates: Array, applied: float
    ) -> Sight:
        """Return it with the axes of the measured pose."""
        return Sight(camera, measured, smooth, level_axes(measured.rotation), rates, applied)

    def pose(self, errors: Array, base: MapPose | None = None) -> MapPose:
        """Return the pose with the platform's errors (7,) taken out."""
        base = self.measured if base is None else base
        late = float(errors[6]) - self.applied
        pose = base.corrected(errors, self.axes)
        if late:
            moved = np.concatenate([-late * self.rates[:3], -late * self.rates[3:]])
            pose = pose.corrected(moved, np.eye(3))
        return pose


@dataclass(frozen=True)
class Linear:
    """The measurement of m robots' pixels to first order.

    Attributes:
        pixels: (m, 2) predicted.
        by_place: (m, 2, 2) derivative by the robots' East, North, px/m.
        by_platform: (m, 2, 7) by the platform's errors.
        by_pose: (m, 2, 6) by the pose's white noise.
        seen: (m,) False where the camera model has no pixel for the robot.
    """

    pixels: Array
    by_place: Array
    by_platform: Array
    by_pose: Array
    seen: NDArray[np.bool_]


@dataclass(frozen=True)
class Outcome:
    """How well an image fitted.

    Attributes:
        squared: normalised squared residual of the whole image.
        count: its degrees of freedom.
    """

    squared: float
    count: int


def linearise(sight: Sight, errors: Array, positions: Array) -> Linear:
    """Return predicted pixels and all derivatives.

    Pixels are exact, at the measured pose with the errors taken out. Derivatives are taken at the
    smooth pose, for the same place on the water: see `smooth_pose`.

    Args:
        sight: the camera.
        errors: (7,) estimate of the platform's errors.
        positions: (m, 2) estimate of the robots' East, North, m.
    """
    points = water_points(positions)
    pose, near = sight.pose(errors), sight.pose(errors, sight.smooth)
    pixels, _ = sight.camera.project((points - pose.position) @ pose.optical)
    offsets = points - near.position
    optical = near.optical
    _, by_point, seen = sight.camera.project_with_jacobian(offsets @ optical)
    by_place = (by_point @ optical.T)[:, :, :2]
    by_pose = pose_jacobian(offsets)
    by_platform = platform_jacobian(by_pose, sight.axes, sight.rates)
    seen = seen & np.isfinite(pixels).all(axis=1) & (offsets[:, 2] < 0.0)
    return Linear(pixels, by_place, -by_place @ by_platform, -by_place @ by_pose, seen)


def correct(
    joint: Joint, slots: Indices, pixels: Array, sight: Sight, model: PlatformModel
) -> Outcome:
    """Take in the pixels of some robots.

    Args:
        joint: changed in place.
        slots: (m,) places of the robots in `joint`.
        pixels: (m, 2) measured.
        sight: the camera.
        model: white noise of pose and boxes.
    """
    before = joint.mean.copy()
    linear = linearise(sight, before[:COUNT], joint.robots[slots, :2])
    if not linear.seen.all():
        slots, pixels = slots[linear.seen], pixels[linear.seen]
        linear = _only(linear, linear.seen)
    m = len(slots)
    if not m:
        return Outcome(0.0, 0)
    by_state = _times_covariance(joint, slots, linear)
    spread = _innovation(joint, slots, linear, by_state, model)
    residual = pixels - linear.pixels
    squared = float(residual.ravel() @ np.linalg.solve(spread, residual.ravel()))
    _soften(spread, residual, model.pixel)
    whiten = np.linalg.inv(np.linalg.cholesky(spread))
    gain = whiten @ by_state
    joint.mean = before + gain.T @ (whiten @ residual.ravel())
    _iterate(joint, before, slots, pixels, sight, linear, whiten, gain)
    joint.covariance -= gain.T @ gain
    joint.unseen[slots] = 0.0
    return Outcome(squared, 2 * m)


def _times_covariance(joint: Joint, slots: Indices, linear: Linear) -> Array:
    """Return H P, (2 m, D); H has the platform's columns and two of one robot in a row."""
    P, m = joint.covariance, len(slots)
    product: Array = linear.by_platform.reshape(2 * m, COUNT) @ P[:COUNT]
    robots = P[COUNT:].reshape(len(joint), 4, -1)[slots, :2]
    product += (linear.by_place @ robots).reshape(2 * m, -1)
    return product


def _innovation(
    joint: Joint, slots: Indices, linear: Linear, by_state: Array, model: PlatformModel
) -> Array:
    """Return the covariance (2 m, 2 m) of the residual."""
    m = len(slots)
    spread: Array = by_state[:, :COUNT] @ linear.by_platform.reshape(2 * m, COUNT).T
    robots = by_state[:, COUNT:].reshape(2 * m, len(joint), 4)[:, slots, :2]
    spread += np.einsum("ajc,jrc->ajr", robots, linear.by_place).reshape(2 * m, 2 * m)
    white = linear.by_pose.reshape(2 * m, -1)
    spread += (white * model.white) @ white.T
    spread.flat[:: 2 * m + 1] += model.pixel
    return spread


def _soften(spread: Array, residual: Array, pixel: float) -> None:
    """Give boxes far off their prediction a larger noise, so that they pull no more than at HUBER.

    Weight w = c/d beyond a normalised distance c: the pixel's variance becomes variance / w.
    """
    m = len(residual)
    own = spread.reshape(m, 2, m, 2)
    every = np.arange(m)
    a, b, d = own[every, 0, every, 0], own[every, 0, every, 1], own[every, 1, every, 1]
    x, y = residual[:, 0], residual[:, 1]
    distance = np.sqrt((d * x * x - 2.0 * b * x * y + a * y * y) / (a * d - b * b))
    if not (distance > HUBER).any():
        return
    more = np.maximum(distance / HUBER - 1.0, 0.0)
    # In units of the whole innovation: also a robot of which little is known is not pulled.
    own[every, 0, every, 0] += more * np.maximum(a, pixel)
    own[every, 1, every, 1] += more * np.maximum(d, pixel)


def _iterate(
    joint: Joint,
    before: Array,
    slots: Indices,
    pixels: Array,
    sight: Sight,
    linear: Linear,
    whiten: Array,
    gain: Array,
) -> None:
    """Repeat the correction from its own result where it went far (iterated filter).

    The derivatives stay: only the residual is taken anew, less what the step should have changed.
    """
    for _ in range(MAX_ITERATIONS):
        robots = joint.robots[slots, :2]
        moved = robots - before[COUNT:].reshape(-1, 4)[slots, :2]
        distance = float(sight.measured.position[2])
        if not (np.abs(moved) > RELINEARISE * distance).any():
            return
        pose = sight.pose(joint.mean[:COUNT])
        points = water_points(robots)
        now, _ = sight.camera.project((points - pose.position) @ pose.optical)
        if not np.isfinite(now).all():
            return
        step = joint.mean - before
        told = linear.by_platform @ step[:COUNT] + (linear.by_place @ moved[:, :, None])[:, :, 0]
        residual = pixels - now + told
        joint.mean = before + gain.T @ (whiten @ residual.ravel())


def _only(linear: Linear, mask: NDArray[np.bool_]) -> Linear:
    return Linear(
        linear.pixels[mask],
        linear.by_place[mask],
        linear.by_platform[mask],
        linear.by_pose[mask],
        linear.seen[mask],
    )
