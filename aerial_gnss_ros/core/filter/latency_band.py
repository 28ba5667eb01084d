# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Candidate latencies next to one another, whose telemetry arrives at about the same time.

What is stamped with a negative latency shows a scene whose telemetry is still to come. So an image
is compared with bands of candidates in turn, each once telemetry for all of them is there.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.latency_bank import BankObservation, LatencyBank, LatencyFit
from aerial_gnss_ros.core.filter.latency_reappearance import Reappearance
from aerial_gnss_ros.core.filter.latency_views import Mask, Views
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyBandTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    steps: int = 10
    """Number of candidates of a band of negative latencies: 1 s. Narrower ones are told sooner, and
    each costs as much time of the processor as a wide one. Judged."""


TUNING = LatencyBandTuning()


def bands(first: int, last: int) -> list[tuple[int, int]]:
    """Return the first and last candidate of each band, the configured latency's band first.

    Args:
        first: the lowest candidate, steps from the configured latency.
        last: the highest one.
    """
    found: list[tuple[int, int]] = []
    while True:
        begin = max(first, -TUNING.steps * (len(found) + 1))
        found.append((begin, last))
        if begin == first:
            return found
        last = begin - 1


class LatencyBand:
    """Compares images with some of the candidates.

    Args:
        model: measurement noise.
        motion: of the robots.
        first: the lowest candidate, steps from the configured latency.
        last: the highest one.
        part: which of all candidates they are.

    Attributes:
        first, last, part: these.
        waiting: images that wait for telemetry.
        last_ns: stamp of the last image that was compared.
    """

    def __init__(
        self, model: PlatformModel, motion: MotionModel, first: int, last: int, part: slice
    ) -> None:
        self.first, self.last, self.part = first, last, part
        self.bank = LatencyBank(model, motion, last - first + 1)
        self._reappearance = Reappearance(model, motion)
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self.waiting: deque[tuple[BankObservation, Array]] = deque()
        self.last_ns: int | None = None
        self.interrupt()

    def interrupt(self) -> None:
        """Compare nothing before with what follows."""
        self.bank.reset()
        self._reappearance.reset()
        self._known: Mask = np.zeros(self.last - self.first + 1, np.bool_)

    def passed(self, stamp_ns: int) -> float:
        """Return the time since the last image, s, and note this one."""
        last_ns, self.last_ns = self.last_ns, stamp_ns
        return 0.0 if last_ns is None else (stamp_ns - last_ns) * 1e-9

    def known(self, posed: Mask) -> Mask:
        """Return which candidates had telemetry for the last image, and have for this one."""
        known, self._known = posed & self._known, posed
        return known

    def compare(
        self, seen: BankObservation, centers: Array, passed: float, views: Views, rotations: Array,
        anew: Mask | None,
    ) -> tuple[tuple[Array, Array] | None, LatencyFit | None]:  # fmt: skip
        """Return how an image fits each candidate, see `Reappearance` and `LatencyBank`.

        Args:
            seen: boxes of labelled robots.
            centers: (n, 2) of all boxes.
            passed: time since the last image, s.
            views: the camera at each of m candidates.
            rotations: (m, 3, 3) camera FLU in `map`.
            anew: (m,) where robots begin anew; None: only labelled robots are compared.
        """
        fit = self.bank.update(seen, passed, views.positions, rotations, anew, views.interpolation)
        if anew is None:
            return None, fit
        return self._reappearance.update(seen.camera, centers, passed, views), fit
