# SPDX-License-Identifier: Apache-2.0
"""Milliseconds per stage, averaged over the last images."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

_REMEMBERED = 50


class Timings:
    """Running means by stage; stages appear in the order in which they came first."""

    def __init__(self) -> None:
        self._stages: dict[str, deque[float]] = {}

    def add(self, timings_ms: Mapping[str, float]) -> None:
        """Take the milliseconds of one image."""
        for stage, value in timings_ms.items():
            self._stages.setdefault(stage, deque(maxlen=_REMEMBERED)).append(value)

    def means_ms(self) -> dict[str, float]:
        """Return the mean of each stage over the last 50 images."""
        return {stage: sum(values) / len(values) for stage, values in self._stages.items()}
