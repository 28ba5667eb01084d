# SPDX-License-Identifier: Apache-2.0
"""What one image tells of the platform's errors and of the robots in it.

Pixels are predicted exactly. Their derivatives by the platform's errors, however, are taken from a
place of the camera that is held until the camera has moved by a share `HOLD` of its distance. Its
place as estimated jitters from image to image with the noise of telemetry and of the state itself,
and that jitter is correlated with the innovation; over hundreds of images it would read as
information on height, heading and tilt which is not there: docs/estimation.md has the figures. A
robot's own motion must show in the derivatives at once: how fast it swims scales with the height.
"""

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

HOLD = 0.03
"""How far the camera may go, as a share of its distance to the robots, and turn about the vertical,
rad, before derivatives are taken from another place. Well above the jitter."""

HOLD_M = 0.8
"""And at most so far, m: from high up the jitter is a smaller share of the distance."""

RELINEARISE = 0.02
"""A robot that a correction moves by this share of its distance is corrected from there anew."""

MAX_ITERATIONS = 3

_EAST_NORTH_UP = np.eye(3)


@dataclass(frozen=True)
class Sight:
    """One image's camera, ready for the filter.

    Attributes:
        camera: lens and image.
        measured: the pose as telemetry has it.
        axes: (3, 3) of roll, pitch and heading errors.
        rates: (6,) of the pose, m/s and rad/s.
        applied: latency that the pose already allows for, beyond the configured one, s.
    """

    camera: CameraModel
    measured: MapPose
    axes: Array
    rates: Array
    applied: float = 0.0

    @staticmethod
    def of(camera: CameraModel, measured: MapPose, rates: Array, applied: float) -> Sight:
        """Return it with the axes of the measured pose."""
        return Sight(camera, measured, level_axes(measured.rotation), rates, applied)

    def pose(self, errors: Array) -> MapPose:
        """Return the pose with the platform's errors (7,) taken out."""
        pose = self.measured.corrected(errors, self.axes)
        late = float(errors[6]) - self.applied
        return pose.corrected(-late * self.rates, _EAST_NORTH_UP) if late else pose


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

    def only(self, mask: NDArray[np.bool_]) -> Linear:
        """Return the robots where `mask` (m,) is true."""
        return Linear(
            self.pixels[mask],
            self.by_place[mask],
            self.by_platform[mask],
            self.by_pose[mask],
            self.seen[mask],
        )


@dataclass(frozen=True)
class Outcome:
    """How well an image fitted.

    Attributes:
        squared: normalised squared innovation of the whole image.
        count: its degrees of freedom.
    """

    squared: float
    count: int


@dataclass(frozen=True)
class Held:
    """From where derivatives by the platform's errors are taken.

    Attributes:
        place: (3,) of the camera, m.
        axes: (3, 3) of roll, pitch and heading errors.
    """

    place: Array
    axes: Array


def linearise(sight: Sight, errors: Array, positions: Array, held: Held | None = None) -> Linear:
    """Return predicted pixels and all derivatives at an estimate.

    Args:
        sight: the camera.
        errors: (7,) estimate of the platform's errors.
        positions: (m, 2) estimate of the robots' East, North, m.
        held: see the module; None: the estimate itself.
    """
    pose = sight.pose(errors)
    points = water_points(positions)
    offsets = points - pose.position
    optical = pose.optical
    pixels, by_point, seen = sight.camera.project_with_jacobian(offsets @ optical)
    by_place = (by_point @ optical.T)[:, :, :2]
    seen = seen & (offsets[:, 2] < 0.0)
    held = held or Held(pose.position, sight.axes)
    by_pose = pose_jacobian(points - held.place)
    by_platform = platform_jacobian(by_pose, held.axes, sight.rates)
    return Linear(pixels, by_place, -by_place @ by_platform, -by_place @ by_pose, seen)


def hold(joint: Joint, sight: Sight) -> Held:
    """Return from where to take derivatives, which goes on only after the camera moved enough."""
    place, axes = sight.pose(joint.mean[:COUNT]).position, sight.axes
    level = joint.robots[:, :2] - place[:2]
    distance = abs(float(place[2]))
    if len(level):
        distance = float(np.median(np.hypot(np.hypot(level[:, 0], level[:, 1]), distance)))
    apart = place - joint.anchor
    turned = axes[:2, 0] - joint.axes[:2, 0]
    near = float(apart @ apart) <= min(HOLD * distance, HOLD_M) ** 2  # false for NaN
    if not (near and float(turned @ turned) <= HOLD**2):
        joint.anchor, joint.axes = place, axes
    return Held(joint.anchor, joint.axes)


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
    before = joint.mean
    linear = linearise(sight, before[:COUNT], joint.robots[slots, :2], hold(joint, sight))
    if not linear.seen.all():
        slots, pixels, linear = slots[linear.seen], pixels[linear.seen], linear.only(linear.seen)
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
    joint.mean = before + (whiten @ residual.ravel()) @ gain
    _iterate(joint, before, slots, pixels, sight, linear, whiten, gain)
    joint.covariance -= gain.T @ gain
    joint.unseen[slots] = 0.0
    return Outcome(squared, 2 * m)


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
    far = RELINEARISE * float(sight.measured.position[2])
    for _ in range(MAX_ITERATIONS):
        robots = joint.robots[slots, :2]
        moved = robots - before[COUNT:].reshape(-1, 4)[slots, :2]
        if not (np.abs(moved) > far).any():
            return
        now = linearise(sight, joint.mean[:COUNT], robots)
        if not now.seen.all():
            return
        step = joint.mean - before
        told = linear.by_platform @ step[:COUNT] + (linear.by_place @ moved[:, :, None])[:, :, 0]
        residual = pixels - now.pixels + told
        joint.mean = before + (whiten @ residual.ravel()) @ gain


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
