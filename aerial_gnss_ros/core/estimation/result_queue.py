# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results until they are taken, in the order of their images, and the account of their boxes."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from aerial_gnss_ros.core.tracker.box_account import Settled, complaint
from aerial_gnss_ros.core.values.estimates import FrameResult, PlatformError, RobotEstimate
from aerial_gnss_ros.core.values.rejection import Cause, Reason, Rejection


class ResultQueue:
    """Keeps results and counts what became of boxes.

    Attributes:
        counts: refused boxes by reason.
        causes: `unconfirmed` boxes by the reason why their tracks were not confirmed.
        boxes: boxes of all images with a result.
        used: number of these that updated robots; some are undecided until the end.
        ending: boxes that were refused after the last result.
        robots: those of the last result.
        platform: the last estimated errors of the platform.
    """

    def __init__(self) -> None:
        self.counts: Counter[Reason] = Counter()
        self.causes: Counter[Cause] = Counter()
        self.boxes = self.used = 0
        self.ending: tuple[Rejection, ...] = ()
        self.robots: tuple[RobotEstimate, ...] = ()
        self.platform: tuple[PlatformError, ...] = ()
        self._due: list[FrameResult] = []

    def add(self, result: FrameResult) -> None:
        """Add the result of the next image."""
        self.robots = result.estimates
        self.platform = result.platform or self.platform
        self.boxes += result.boxes
        self._count(result.used, result.rejections)
        self._count(0, result.late)
        self._due.append(result)

    def decide(self, settled: Settled) -> None:
        """Add decisions on boxes of earlier images to the result added last, not taken yet."""
        self._count(settled.used, settled.refused)
        last = self._due[-1]
        late = (*last.late, *settled.refused)
        self._due[-1] = replace(last, used=last.used + settled.used, late=late)

    def end(self, settled: Settled) -> None:
        """Count decisions after the last result."""
        self._count(settled.used, settled.refused)
        self.ending = settled.refused

    def take(self) -> list[FrameResult]:
        """Return the results since the last call."""
        due, self._due = self._due, []
        return due

    def forget_robots(self) -> None:
        """Have no robots until the next result: their tracks have ended."""
        self.robots, self.platform = (), ()

    @property
    def complaint(self) -> str:
        """Why most boxes are refused, a sentence; empty if most update robots."""
        return complaint(self.used, self.counts, self.causes)

    def _count(self, used: int, refused: tuple[Rejection, ...]) -> None:
        self.used += used
        for one in refused:
            self.counts[one.reason] += 1
            if one.cause is not None:
                self.causes[one.cause] += 1
