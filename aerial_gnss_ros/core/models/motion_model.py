# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How robots move: straight on while they are in sight, unknown where to when they are not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig

Array = NDArray[np.float64]

TURN_S = 2.0
"""Out of sight a robot's velocity loses its memory with this time constant, for so long, s."""

CRUISE_S = 10.0
"""Time constant of the unknown velocity that it has from then on, s."""

HELD_S = 0.5
"""A robot that an image missed holds its course so long, s."""

HELD_SEEN_S = 2.0
"""The same for one that the last image measured: images may be seconds apart."""


class Motion:
    """How robots move.

    In sight: white acceleration. Out of sight the robot may turn, so that after a moment its
    velocity goes to zero mean and `speed_sigma` (Ornstein-Uhlenbeck): at first fast, that a robot
    which turned back at the edge of the view is found again; then slowly, that one which swims
    straight on is as well.

    Attributes:
        acceleration: root of the spectral density, m/s^1.5.
        speed_sigma: of an unknown velocity, each axis, m/s.
    """

    def __init__(self, acceleration: float, speed_sigma: float) -> None:
        self.acceleration = acceleration
        self.speed_sigma = speed_sigma

    @property
    def fastest(self) -> float:
        """Fastest speed of a robot, m/s: `tracks.max_speed`."""
        return 2.0 * self.speed_sigma

    def step(
        self, seconds: float, unseen: Array, strength: Array | float = 1.0
    ) -> tuple[Array, Array | None, Array]:
        """Return reach (n,), kept velocity (n,) and noise (n, 3): pp, pv, vv, of a time step.

        position += reach * velocity; velocity *= kept, where that is not None (all of it).

        Args:
            seconds: length of the step, s.
            unseen: (n,) time since each robot was measured at the step's beginning, s.
            strength: (n,) of their accelerations' densities, see `Manoeuvres`.
        """
        if seconds <= HELD_SEEN_S and not np.count_nonzero(unseen):
            return self._straight(seconds, len(unseen), strength)
        held = np.where(unseen > 0.0, HELD_S, HELD_SEEN_S)
        straight = np.clip(held - unseen, 0.0, seconds)
        q = self.acceleration**2 * strength
        noise = np.empty((len(unseen), 3))
        noise[:, 0] = q * straight**3 / 3.0
        noise[:, 1] = q * straight**2 / 2.0
        noise[:, 2] = q * straight
        left = seconds - straight
        if not left.any():
            return straight, None, noise
        turning = np.clip(held + TURN_S - unseen - straight, 0.0, left)
        reach, kept = straight, np.ones(len(unseen))
        for time, length in ((TURN_S, turning), (CRUISE_S, left - turning)):
            keep = np.exp(-length / time)
            reach = reach + kept * time * (1.0 - keep)
            kept = kept * keep
            self._forget(noise, time, length, keep)
        return reach, kept, noise

    def _straight(
        self, seconds: float, count: int, strength: Array | float
    ) -> tuple[Array, None, Array]:
        """Return the step of robots that were all in view just now."""
        q = self.acceleration**2
        once = [q * seconds**3 / 3.0, q * seconds**2 / 2.0, q * seconds]
        reach = np.array([seconds] * count)
        return reach, None, np.multiply.outer(np.zeros(count) + strength, once)

    def _forget(self, noise: Array, time: float, length: Array, keep: Array) -> None:
        """Carry noise (n, 3) through a time without memory, and add what comes in it."""
        arm, s2 = time * (1.0 - keep), self.speed_sigma**2
        noise[:, 0] += 2.0 * arm * noise[:, 1] + arm**2 * noise[:, 2]
        noise[:, 1] = keep * (noise[:, 1] + arm * noise[:, 2])
        noise[:, 2] *= keep**2
        spread = 2.0 * length / time - 3.0 + 4.0 * keep - keep**2
        noise[:, 0] += s2 * time**2 * np.maximum(spread, 0.0)
        noise[:, 1] += s2 * time * (1.0 - keep) ** 2
        noise[:, 2] += s2 * (1.0 - keep**2)


def motion_of(config: EstimatorConfig) -> Motion:
    """Return how robots move by the parameters."""
    speed = 0.5 * config.tracks.max_speed
    return Motion(config.noise.value("robot_acceleration"), speed)
