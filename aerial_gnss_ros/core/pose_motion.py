# SPDX-License-Identifier: Apache-2.0
"""How fast the camera's pose moves, and where it should be by its own past."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.joint_geometry import MapPose, rotation_matrix, rotation_vector

Array = NDArray[np.float64]

MEMORY_S = 0.5
"""Time constant of the fading memory (critically damped, second order)."""

MAX_GAP_S = 1.0
"""After a longer pause the past tells nothing."""

MOVED_S = 0.02
"""A latency that is corrected by more puts the scene to another time (`PoseMotion.move`)."""


class PoseMotion:
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

    def predicted(self, seconds: float) -> Array | None:
        """Return the position (3,) expected after a time, None where the past does not tell."""
        if self._pose is None or abs(seconds) > MAX_GAP_S:
            return None
        position: Array = self._pose.position + self.velocity * seconds
        return position

    def foreseen(self, seconds: float) -> MapPose | None:
        """Return the pose expected after a time, None where the past does not tell."""
        if self._pose is None or seconds > MAX_GAP_S:
            return None
        turn = rotation_matrix(self.turn_rate * seconds)
        return MapPose(self._pose.position + self.velocity * seconds, turn @ self._pose.rotation)

    def shift(self, jump: Array) -> None:
        """Go over to positions (3,) m away: the drone did not fly there."""
        if self._pose is not None:
            self._pose = MapPose(self._pose.position + jump, self._pose.rotation)

    def move(self, measured: MapPose) -> MapPose:
        """Go on from a pose at another time, when the latency is known better; rates stay."""
        self._pose = measured
        return measured

    def take(self, measured: MapPose, seconds: float) -> MapPose:
        """Take in the pose of an image so many seconds after the one before.

        Returns:
            The pose that was expected; where the past does not tell, the measured one.
        """
        expected = self.foreseen(seconds) if seconds > 0.0 else None
        if expected is None:
            self._pose, self._seen = measured, 1
            self.velocity, self.turn_rate = np.zeros(3), np.zeros(3)
            return measured
        shift = measured.position - expected.position
        turn = rotation_vector(measured.rotation @ expected.rotation.T)
        self._seen += 1
        alpha, beta = self._gains(seconds)
        self._pose = MapPose(
            expected.position + alpha * shift, rotation_matrix(alpha * turn) @ expected.rotation
        )
        self.velocity = self.velocity + (beta / seconds) * shift
        self.turn_rate = self.turn_rate + (beta / seconds) * turn
        return expected

    def _gains(self, seconds: float) -> tuple[float, float]:
        """Return the gains of a straight line through all images so far, later a fading one."""
        k = self._seen
        fade = math.exp(-seconds / MEMORY_S)
        alpha = max(2.0 * (2 * k - 1) / (k * (k + 1)), 1.0 - fade * fade)
        beta = max(6.0 / (k * (k + 1)), (1.0 - fade) ** 2)
        return min(alpha, 1.0), min(beta, 1.0)
