# SPDX-License-Identifier: Apache-2.0
"""Where the camera's pose should be by its own past: for linearisation, and how fast it moves.

Each measured pose carries fresh white noise. Were the Jacobians taken there, they would be
correlated with the residual that they multiply; over hundreds of images that reads as information
on heading and tilt that is not there (errors in variables; docs/estimation.md has the figures). The
prediction of a fading-memory filter from earlier images alone is independent of this image's noise.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.joint_geometry import MapPose, rotation_matrix, rotation_vector

Array = NDArray[np.float64]

MEMORY_S = 0.5
"""Time constant of the fading memory (critically damped, second order)."""

MAX_TURN = 0.01
"""rad: a camera that turned further than its past told is taken where it is measured."""

MAX_GAP_S = 1.0
"""After a longer pause the past tells nothing."""


class SmoothPose:
    """A fading-memory straight-line fit of position and rotation.

    Attributes:
        velocity: (3,) m/s.
        turn_rate: (3,) rotation vector a second in `map`, rad/s.
    """

    def __init__(self) -> None:
        self._pose: MapPose | None = None
        self.velocity = np.zeros(3)
        self.turn_rate = np.zeros(3)
        self._seen = 0

    @property
    def rates(self) -> Array:
        """(6,) of the pose: m/s and rad/s."""
        return np.concatenate([self.velocity, self.turn_rate])

    def predicted(self, seconds: float) -> MapPose | None:
        """Return the pose expected after a time, None where the past does not tell."""
        if self._pose is None or seconds > MAX_GAP_S:
            return None
        return MapPose(
            self._pose.position + self.velocity * seconds,
            rotation_matrix(self.turn_rate * seconds) @ self._pose.rotation,
        )

    def shift(self, jump: Array) -> None:
        """Go over to positions (3,) m away: the drone did not fly there."""
        if self._pose is not None:
            self._pose = MapPose(self._pose.position + jump, self._pose.rotation)

    def take(self, measured: MapPose, seconds: float) -> MapPose:
        """Take in a pose; return where to linearise for it.

        Args:
            measured: the pose of this image.
            seconds: since the one before.
        """
        predicted = self.predicted(seconds)
        if predicted is None or seconds <= 0.0:
            self._pose, self._seen = measured, 1
            self.velocity, self.turn_rate = np.zeros(3), np.zeros(3)
            return measured
        shift = measured.position - predicted.position
        turn = rotation_vector(measured.rotation @ predicted.rotation.T)
        self._seen += 1
        alpha, beta = self._gains(seconds)
        near_shift = math.sqrt(float(shift @ shift)) < MAX_TURN * max(
            1.0, abs(float(measured.position[2]))
        )
        near_turn = math.sqrt(float(turn @ turn)) < MAX_TURN
        by, about = (alpha if near_shift else 1.0), (alpha if near_turn else 1.0)
        self._pose = MapPose(
            predicted.position + by * shift,
            rotation_matrix(about * turn) @ predicted.rotation,
        )
        self.velocity = self.velocity + (beta / seconds) * shift
        self.turn_rate = self.turn_rate + (beta / seconds) * turn
        return MapPose(
            predicted.position if near_shift else measured.position,
            predicted.rotation if near_turn else measured.rotation,
        )

    def _gains(self, seconds: float) -> tuple[float, float]:
        """Return the gains of a straight line through all images so far, later a fading one."""
        k = self._seen
        fade = math.exp(-seconds / MEMORY_S)
        alpha = max(2.0 * (2 * k - 1) / (k * (k + 1)), 1.0 - fade * fade)
        beta = max(6.0 / (k * (k + 1)), (1.0 - fade) ** 2)
        return min(alpha, 1.0), min(beta, 1.0)
