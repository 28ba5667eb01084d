# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Seeded random processes: independent streams by name, smooth wander, Gauss-Markov drift."""

from __future__ import annotations

import math
import zlib

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def generator(seed: int, name: str) -> np.random.Generator:
    """Return an independent random stream for each name."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())])


class Wander:
    """A smooth random function of time: a few sinusoids of random frequency and phase."""

    def __init__(
        self, rng: np.random.Generator, rms: float, low_hz: float, high_hz: float, parts: int = 5
    ) -> None:
        """Draw the function.

        Args:
            rng: where the chance comes from.
            rms: root mean square of the values.
            low_hz: lowest frequency, Hz.
            high_hz: highest frequency, Hz.
            parts: number of sinusoids.
        """
        self._rate = 2.0 * np.pi * rng.uniform(low_hz, high_hz, parts)
        self._phase = rng.uniform(0.0, 2.0 * np.pi, parts)
        self._amplitude = rms * math.sqrt(2.0 / parts)

    def __call__(self, t: Array) -> Array:
        """Return the values (n,) at times (n,) in s."""
        angle = np.asarray(t)[:, None] * self._rate + self._phase
        return np.asarray(self._amplitude * np.sin(angle).sum(axis=1))


class Drift:
    """A first-order Gauss-Markov process: a slow sensor error.

    It starts in its steady state, so its standard deviation is constant, and its correlation falls
    as exp(-|dt| / correlation time).
    """

    STEP_S = 0.1

    def __init__(
        self,
        rng: np.random.Generator,
        sigma: float,
        correlation_time_s: float,
        start_s: float,
        end_s: float,
    ) -> None:
        """Draw the process on a fine grid over a span of time.

        Args:
            rng: where the chance comes from.
            sigma: standard deviation, any unit.
            correlation_time_s: s; infinite for a constant.
            start_s: first time needed, s.
            end_s: last time, s.
        """
        n = max(2, math.ceil((end_s - start_s) / self.STEP_S) + 2)
        self._times = start_s + self.STEP_S * np.arange(n)
        normal = rng.standard_normal(n)
        keep = math.exp(-self.STEP_S / correlation_time_s) if correlation_time_s > 0.0 else 0.0
        fresh = math.sqrt(1.0 - keep * keep)
        values = np.empty(n)
        values[0] = normal[0]
        for i in range(1, n):
            values[i] = keep * values[i - 1] + fresh * normal[i]
        self._values = sigma * values

    def __call__(self, t: Array) -> Array:
        """Return the values (n,) at times (n,) in s."""
        return np.interp(t, self._times, self._values)
