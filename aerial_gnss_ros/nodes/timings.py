# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Duration of each stage over the last images."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

_REMEMBERED = 300


class Timings:
    """Milliseconds by stage, in the order in which stages first appeared.

    Args:
        remembered: number of last images that count.
    """

    def __init__(self, remembered: int = _REMEMBERED) -> None:
        self._remembered = remembered
        self._stages: dict[str, deque[float]] = {}

    def remember(self, images: int) -> None:
        """Clear, and keep this many images from now on."""
        self._remembered = images
        self._stages = {}

    def add(self, timings_ms: Mapping[str, float]) -> None:
        """Add the milliseconds of one image."""
        for stage, value in timings_ms.items():
            if stage not in self._stages:
                self._stages[stage] = deque(maxlen=self._remembered)
            self._stages[stage].append(value)

    def samples_ms(self) -> dict[str, list[float]]:
        """Return the duration of each stage for each image that counts, ms."""
        return {stage: list(values) for stage, values in self._stages.items()}

    def means_ms(self) -> dict[str, float]:
        """Return the mean of each stage, ms."""
        return {stage: sum(values) / len(values) for stage, values in self.samples_ms().items()}

    def p95_ms(self) -> dict[str, float]:
        """Return the 95th percentile of each stage, ms."""
        return {stage: _p95(values) for stage, values in self.samples_ms().items()}


def _p95(values: list[float]) -> float:
    return sorted(values)[math.ceil(0.95 * len(values)) - 1]


class Waits:
    """Waiting time of each image, by its stamp; bounded."""

    _MOST = 4096

    def __init__(self) -> None:
        self._since: dict[int, float] = {}

    def begin(self, stamp_ns: int, now_s: float) -> None:
        """Record the time at which an image begins to wait."""
        if len(self._since) >= self._MOST:
            self._since.pop(next(iter(self._since)))
        self._since[stamp_ns] = now_s

    def end(self, stamp_ns: int, now_s: float) -> float:
        """Return the waiting time of an image, ms; NaN for an unknown one."""
        return 1e3 * (now_s - self._since.pop(stamp_ns, math.nan))
