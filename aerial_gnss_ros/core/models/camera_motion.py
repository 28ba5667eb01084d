# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion of the camera's pose: rates, turns, prediction, jumps of orientation and height."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix, rotation_vector
from aerial_gnss_ros.core.numerics.usual_step import UsualStep

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CameraMotionTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    fading_s: float = 0.5
    """Time constant of the fading memory (critically damped, second order). Judged."""
    max_gap_s: float = 1.0
    """Gap after which the past predicts nothing, s. Judged."""
    shortest_s: float = 0.005
    """Least time between poses that determine a velocity, s; below, differences are noise.
    Telemetry comes at 200 Hz at most."""
    moved_s: float = 0.02
    """Least correction of the latency that counts as another time of the scene, s. Judged."""
    jump_rad: float = math.radians(10.0)
    """Greatest deviation of a turning camera from its predicted orientation, plus `jump_radps`,
    rad. From recorded DJI flights."""
    jump_radps: float = math.radians(90.0)
    """Growth of that angle with the time since the last image, rad/s. Cameras start to turn at 100
    deg/s from one image to the next, but not at 200. From recorded DJI flights."""
    climb_mps: float = 10.0
    """Greatest climb rate of a drone, m/s. Judged: twice that of consumer drones."""
    first_climb_m: float = 1.0
    """Usual step of the height before the first, m. Judged."""


TUNING = CameraMotionTuning()


class CameraMotion:
    """A fading-memory straight-line fit of position and rotation.

    Attributes:
        jump: rotation vector (3,) in `map` from the expected to the last rotation, rad, if it is
            larger than a camera turns; else None.
        height_jump: step of the last height, m, if no drone climbs so fast; else 0.
        velocity: (3,) m/s.
        turn_rate: (3,) rotation vector a second in `map`, rad/s.
        rates: (6,) both.
    """

    def __init__(self) -> None:
        self._pose: MapPose | None = None
        self.velocity = np.zeros(3)
        self.turn_rate = np.zeros(3)
        self.rates = np.zeros(6)
        self.jump: Array | None = None
        self.height_jump = 0.0
        self._usual_climb = UsualStep(TUNING.first_climb_m)
        self._height: float | None = None
        self._lasted_s = 0.0
        self._shown: list[tuple[Array, float]] = []  # measured rotations; s since the previous one

    def shift(self, jump: Array) -> None:
        """Move to positions (3,) m away: the receiver jumped, not the drone."""
        if self._pose is not None:
            self._pose = MapPose(self._pose.position + jump, self._pose.rotation)

    def restart(self, measured: MapPose) -> MapPose:
        """Continue from a pose at another time after a latency correction; rates are kept."""
        self._pose, self._shown, self.jump = measured, [], None
        self._height, self.height_jump = float(measured.position[2]), 0.0
        return measured

    def update(self, measured: MapPose, seconds: float) -> MapPose:
        """Update with the pose of an image some seconds after the previous one.

        Returns:
            The predicted pose; without a recent past the measured one.
        """
        before, self.jump = self._pose, None
        self._climb(float(measured.position[2]), seconds)
        if before is None or not 0.0 < seconds <= TUNING.max_gap_s:
            self._pose, self._lasted_s = measured, 0.0
            self.velocity, self.turn_rate, self.rates = np.zeros(3), np.zeros(3), np.zeros(6)
            self._shown = [(measured.rotation, 0.0)]
            return measured
        self._lasted_s += seconds
        alpha, beta = self._gains(seconds)
        farthest = _farthest(seconds)
        turn = rotation_matrix(self.turn_rate * seconds)
        expected = MapPose(before.position + self.velocity * seconds, turn @ before.rotation)
        shift = measured.position - expected.position
        turn = rotation_vector(measured.rotation @ expected.rotation.T)
        if math.sqrt(turn @ turn) > farthest and self._jumps(measured, seconds):
            expected, turn = MapPose(expected.position, measured.rotation), np.zeros(3)
        self._shown = [*self._shown[-1:], (measured.rotation, seconds)]
        self._pose = MapPose(
            expected.position + alpha * shift, rotation_matrix(alpha * turn) @ expected.rotation
        )
        self.velocity = self.velocity + (beta / seconds) * shift
        self.turn_rate = self.turn_rate + (beta / seconds) * turn
        self.rates = np.concatenate([self.velocity, self.turn_rate])
        return expected

    def _climb(self, height: float, seconds: float) -> None:
        """Update with a height, m, some seconds after the previous one."""
        before, self._height, self.height_jump = self._height, height, 0.0
        if before is None or not seconds > 0.0:
            return
        step = height - before
        if self._usual_climb.is_odd(abs(step), TUNING.climb_mps * seconds):
            self.height_jump = step
            return
        self._usual_climb.update(step, seconds)

    def _jumps(self, measured: MapPose, seconds: float) -> bool:
        """Return whether the orientation has jumped from that of the last two images."""
        if not self._shown:
            return False
        (earlier, _), (last, passed) = self._shown[0], self._shown[-1]
        turn = rotation_vector(last @ earlier.T) * (seconds / passed if passed else 0.0)
        jump = rotation_vector(measured.rotation @ (rotation_matrix(turn) @ last).T)
        if not math.sqrt(jump @ jump) > _farthest(seconds):
            return False
        self.jump = jump  # the motion continues from there
        self._shown = [(rotation_matrix(jump) @ last, 0.0)]
        return True

    def _gains(self, seconds: float) -> tuple[float, float]:
        """Return the gains of a straight-line fit to all images so far, later with fading memory.

        A line through k equally spaced images is weighted by its time span: an image right after
        another one adds almost nothing to the velocity.
        """
        k = 1.0 + self._lasted_s / seconds
        fade = math.exp(-seconds / TUNING.fading_s)
        alpha = max(2.0 * (2.0 * k - 1.0) / (k * (k + 1.0)), 1.0 - fade * fade)
        beta = max(6.0 / (k * (k + 1.0)), (1.0 - fade) ** 2)
        return min(alpha, 1.0), min(beta, seconds / TUNING.shortest_s, 1.0)


def _farthest(seconds: float) -> float:
    """Return the greatest deviation of a turning camera from its predicted orientation, rad."""
    return TUNING.jump_rad + TUNING.jump_radps * seconds
