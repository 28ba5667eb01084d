# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion models of robots: nearly constant velocity in view, Ornstein-Uhlenbeck out of view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig

Array = NDArray[np.float64]
Numbers = TypeVar("Numbers", float, NDArray[np.float64])


@dataclass(frozen=True)
class MotionModelTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    turn_s: float = 2.0
    """Time constant with which a robot's velocity decays at first when it is out of view, and how
    long that lasts, s. A robot at 0.7 m/s turns back within about this time."""
    cruise_s: float = 10.0
    """Time constant of its unknown velocity from then on, s. Judged."""
    held_s: float = 0.5
    """Time for which a missed robot holds its course, s. Judged."""
    held_seen_s: float = 2.0
    """The same for a robot that the last image measured, s: images may be seconds apart. Judged."""
    swerve_s: float = 0.5
    """Greatest age of an unnoticed change of velocity, s. Judged."""


TUNING = MotionModelTuning()


class MotionOf(Generic[Numbers]):
    """Motion of robots: with common parameters, or arrays (n,) of them.

    In view: white acceleration. Out of view the robot may turn, so after a moment its velocity
    tends to zero mean and `speed_sigma` (Ornstein-Uhlenbeck): at first fast, so that a robot that
    turned back at the edge of the view is reacquired; then slowly, for one that swims straight on.

    Attributes:
        acceleration: root of the spectral density, m/s^1.5.
        speed_sigma: of an unknown velocity, each axis, m/s.
    """

    def __init__(self, acceleration: Numbers, speed_sigma: Numbers) -> None:
        self.acceleration: Numbers = acceleration
        self.speed_sigma: Numbers = speed_sigma

    @property
    def fastest(self) -> Numbers:
        """Fastest speed of a robot, m/s: `tracks.max_speed`."""
        return 2.0 * self.speed_sigma

    def step(
        self, seconds: float, unseen: Array, strength: Array | float = 1.0
    ) -> tuple[Array, Array | None, Array]:
        """Return reach (n,), kept velocity (n,) and noise (n, 3): pp, pv, vv, of a time step.

        position += reach * velocity; velocity *= kept, unless that is None (1).

        Args:
            seconds: length of the step, s.
            unseen: (n,) time since each robot was measured at the step's beginning, s.
            strength: (n,) of their accelerations' densities, see `ManoeuvreNoise`.
        """
        if seconds <= TUNING.held_seen_s and not any(unseen.tolist()):
            return self._straight(seconds, len(unseen), strength)
        held = np.where(unseen > 0.0, TUNING.held_s, TUNING.held_seen_s)
        straight = np.clip(held - unseen, 0.0, seconds)
        q = self.acceleration**2 * strength
        noise = np.empty((len(unseen), 3))
        noise[:, 0] = q * straight**3 / 3.0
        noise[:, 1] = q * straight**2 / 2.0
        noise[:, 2] = q * straight
        left = seconds - straight
        if not left.any():
            return straight, None, noise
        turning = np.clip(held + TUNING.turn_s - unseen - straight, 0.0, left)
        reach, kept = straight, np.ones(len(unseen))
        for time, length in ((TUNING.turn_s, turning), (TUNING.cruise_s, left - turning)):
            keep = np.exp(-length / time)
            reach = reach + kept * time * (1.0 - keep)
            kept = kept * keep
            self._forget(noise, time, length, keep)
        return reach, kept, noise

    def _straight(
        self, seconds: float, count: int, strength: Array | float
    ) -> tuple[Array, None, Array]:
        """Return the step of robots that were all in view until now."""
        q: Any = self.acceleration**2
        once = [q * seconds**3 / 3.0, q * seconds**2 / 2.0, q * seconds]
        reach = np.array([seconds] * count)
        if isinstance(q, np.ndarray):
            return reach, None, (strength * np.array(once)).T
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


MotionModel = MotionOf[float]
"""Motion of robots with common parameters."""


class ClassMotions:
    """Motion of robots by class.

    Attributes:
        default: of classes without their own parameters.
        default_speed: its `speed_sigma`, m/s.
        words: the greatest speed for messages.
        largest: one sigma of an unknown velocity, each axis, of the fastest class, m/s.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        self.default = motion_model(config)
        self.default_speed = _motion(config)[1]
        self.words = f"tracks.max_speed ({2.0 * self.default_speed:g} m/s)"
        if config.classes:
            self.words += " or the max_speed of its class"
        self._own = {name: _motion(config, name) for name, _ in config.classes}
        self.largest = max(one[1] for one in (_motion(config), *self._own.values()))

    @property
    def alike(self) -> bool:
        """Whether no class has its own parameters."""
        return not self._own

    def of(self, class_ids: Sequence[str]) -> Array | None:
        """Return accelerations and speed sigmas (2, n) by class, NaN: default; None: all are."""
        if not self._own:
            return None
        found = [self._own.get(name, (np.nan, np.nan)) for name in class_ids]
        return np.array(found).reshape(-1, 2).T


def fastest(config: EstimatorConfig) -> float:
    """Return the speed of the fastest class, m/s."""
    return 2.0 * ClassMotions(config).largest


def motion_model(config: EstimatorConfig) -> MotionModel:
    """Return the motion model of robots without a class of their own."""
    return MotionModel(*_motion(config))


def _motion(config: EstimatorConfig, class_id: str = "") -> tuple[float, float]:
    one = config.robot_class(class_id)
    return one.acceleration, 0.5 * one.max_speed


def manoeuvre_covariance(speed: Array | float) -> Array:
    """Return the position covariance (…, 2, 2) of an unnoticed manoeuvre, m².

    Args:
        speed: (…) one sigma of the change of velocity, each axis, m/s.
    """
    more: Array = np.square(TUNING.swerve_s * np.asarray(speed))[..., None, None] * np.eye(2)
    return more
