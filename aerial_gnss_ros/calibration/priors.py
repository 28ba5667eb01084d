# SPDX-License-Identifier: Apache-2.0
"""What is known of a recording's unknowns before its boxes are looked at, from the noise set."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.fit import unknown
from aerial_gnss_ros.calibration.model import DRIFTING, FOCAL, LATENCY, Layout
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.joint_platform import PlatformModel
from aerial_gnss_ros.core.noise import Noise

Array = NDArray[np.float64]

FOCAL_NOISE = 1.0
"""How well a stated focal length is known that the flight does not tell, %."""
_NOISE_KEYS = {
    "gnss_east": "gnss_offset_m",
    "gnss_north": "gnss_offset_m",
    "height": "height_m",
    "gimbal_roll": "gimbal_roll_deg",
    "gimbal_pitch": "gimbal_pitch_deg",
    "heading": "heading_deg",
}


class Priors:
    """Standard deviations before the data.

    Args:
        config: with the noise and the gimbal's reference.
        layout: of the unknowns.
        names: of the constants that are asked for.
        speed: how fast robots may move, m/s.
    """

    def __init__(
        self, config: EstimatorConfig, layout: Layout, names: tuple[str, ...], speed: float
    ) -> None:
        self._noise: Noise = config.noise
        self._white = PlatformModel(config.noise, config.gimbal.reference).white
        self._layout, self._names, self._speed = layout, names, speed
        time_s = max(config.noise.value("correlation_time_s"), 1e-3)
        self._rate = 2.0 / time_s
        """A drift's variance grows by this times its own, a second."""

    def slow(self, name: str) -> float:
        """Return one sigma of a drifting error, m or rad."""
        key = _NOISE_KEYS[name]
        return self._noise.value(key) * (math.radians(1.0) if key.endswith("_deg") else 1.0)

    def own(self, alike: float = 1.0) -> Array:
        """Return the variances (6,) of an image's own errors.

        White noise, and what a drift does between knots: a bridge with a mean variance of 1/6 of
        the step's.

        Args:
            alike: how many images have the same bridge; so often it counts.
        """
        drift = np.square([self.slow(name) for name in DRIFTING])
        bridge = self._rate * self._layout.step_s * drift / 6.0
        return np.maximum(self._white + alike * bridge, 1e-18)

    def alike(self, images: int) -> float:
        """Return how many of so many images share a bridge: those of half a step."""
        layout = self._layout
        rate = images / max(layout.step_s * (layout.knots - 1), 1e-3)
        return max(1.0, 0.5 * layout.step_s * rate)

    def information(self, tight: frozenset[str]) -> Array:
        """Return the unknowns' information matrix; constants in `tight` are as the noise set says.

        The others are as good as free.
        """
        layout = self._layout
        prior = np.zeros((layout.size, layout.size))
        focal = unknown("focal").prior if "focal" in self._names else 1e-3
        if "focal" in tight:
            focal = FOCAL_NOISE
        prior[LATENCY, LATENCY] = _information(unknown("latency").prior)
        prior[FOCAL, FOCAL] = _information(focal / unknown("focal").scale)
        for name in DRIFTING:
            columns = layout.drift(name)
            mean = np.zeros(layout.size)
            mean[columns] = 1.0 / len(columns)
            prior += _information(self._first(name, tight)) * np.outer(mean, mean)
            step = self.slow(name) * math.sqrt(self._rate * layout.step_s)
            _walk(prior, columns, max(step, 1e-9))
        roam = max(self._speed * layout.robot_step_s, 1e-3)
        for robot in range(len(layout.robots)):
            for axis in range(2):
                columns = layout.place(robot)[:, axis]
                prior[columns, columns] += _information(100.0)
                _walk(prior, columns, roam)
        return prior

    def _first(self, name: str, tight: frozenset[str]) -> float:
        """Return one sigma of a drift's mean."""
        if name.startswith("gnss"):
            return 1e-3  # a constant offset moves robots and drone alike
        if name in tight:
            return max(self.slow(name), 1e-6)
        return unknown(name).prior / unknown(name).scale


def _information(sigma: float) -> float:
    return 1.0 / sigma**2


def _walk(prior: Array, columns: NDArray[np.intp], sigma: float) -> None:
    """Let neighbouring knots differ by so much."""
    information = _information(sigma)
    for a, b in itertools.pairwise(columns):
        prior[a, a] += information
        prior[b, b] += information
        prior[a, b] -= information
        prior[b, a] -= information
