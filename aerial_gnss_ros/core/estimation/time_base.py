# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A continuous time base across steps of the clock that stamps messages.

Stamps are shifted on input and shifted back on output, so that processing sees no step. All stamps
are shifted equally: the relative timing of inputs follows from their stamps, which are more
accurate than arrivals.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from typing import TypeVar

from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.rejection import Rejection
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

Value = TypeVar("Value", bound=Fix | Orientation | Scalar | DetectionFrame)

MOST = 16
"""Number of steps kept."""


class TimeBase:
    """Shifts stamps.

    Attributes:
        shift_ns: time less stamps, ns.
        begins: times from which stamps were shifted by more, ns; empty without steps.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset: times equal stamps."""
        self.shift_ns = 0
        self.begins: list[int] = []
        self._shifts = [0]

    def step_ns(
        self, decision: Decision, passed_s: float | None, last_ns: int | None
    ) -> int | None:
        """Return the step of stamps beyond the elapsed time, ns; None: unknown.

        Args:
            decision: on the stamps.
            passed_s: time since the last image before it arrived, s; None: unknown.
            last_ns: time of that image, ns; None: there is none.
        """
        by_ns = decision.by_ns
        if not decision.timed:
            if not decision.stepped or passed_s is None:
                return None
            by_ns -= round(passed_s * 1e9)
        if last_ns is None:
            return None
        # Arrivals vary, but the first image is after the last one in any case.
        return min(by_ns, self.of(decision.first_ns) - last_ns - 1)

    def step(self, by_ns: int, last_ns: int) -> None:
        """Record a step of stamps.

        Args:
            by_ns: the step beyond the elapsed time, ns.
            last_ns: time of the last image before it, ns.
        """
        self.shift_ns -= by_ns
        self.begins.append(last_ns + 1)
        self._shifts.append(self.shift_ns)
        del self.begins[:-MOST], self._shifts[: -MOST - 1]

    def of(self, stamp_ns: int) -> int:
        """Return the time of a stamp."""
        return stamp_ns + self.shift_ns

    def shifted(self, value: Value) -> Value:
        """Return a value by its time."""
        return replace(value, stamp_ns=self.of(value.stamp_ns)) if self.begins else value

    def stamped(self, result: FrameResult) -> FrameResult:
        """Return a result with its image's own stamps."""
        if not self.begins:
            return result
        shift = self.shift_ns
        return replace(
            result,
            stamp_ns=result.stamp_ns - shift,
            estimates=tuple(
                replace(one, stamp_ns=one.stamp_ns - shift, last_seen_ns=one.last_seen_ns - shift)
                for one in result.estimates
            ),
            rejections=self.refused(result.rejections),
            late=self.refused(result.late),
            pose=result.pose and replace(result.pose, stamp_ns=result.pose.stamp_ns - shift),
        )

    def refused(self, boxes: tuple[Rejection, ...]) -> tuple[Rejection, ...]:
        """Return refused boxes with their own images' stamps, which may be older than a step."""
        if not self.begins:
            return boxes
        return tuple(replace(one, stamp_ns=self._stamp(one.stamp_ns)) for one in boxes)

    def _stamp(self, time_ns: int) -> int:
        return time_ns - self._shifts[bisect_right(self.begins, time_ns)]
