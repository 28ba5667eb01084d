# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A time that goes on while the clock that stamps messages steps.

Stamps are shifted on their way in and shifted back on their way out, so that whatever works in
between sees no step. All stamps are shifted alike: how inputs lie to one another in time must be
told by their stamps, which know it better than their arrival does.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from typing import TypeVar

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.rejection import Rejection
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

Value = TypeVar("Value", bound=Fix | Orientation | Scalar | DetectionFrame)

MOST = 16
"""Steps that are remembered."""


class TimeBase:
    """Shifts stamps.

    Attributes:
        shift_ns: time less stamps, ns.
        begins: times from which on stamps were shifted by more, ns; empty: they never were.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Let times be stamps."""
        self.shift_ns = 0
        self.begins: list[int] = []
        self._shifts = [0]

    def step(self, by_ns: int, last_ns: int) -> None:
        """Take in that stamps have moved.

        Args:
            by_ns: by how much more than time has passed, ns.
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
        """Return a result as its image is stamped."""
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
        """Return refused boxes as their own images are stamped, which may be older than a step."""
        if not self.begins:
            return boxes
        return tuple(replace(one, stamp_ns=self._stamp(one.stamp_ns)) for one in boxes)

    def _stamp(self, time_ns: int) -> int:
        return time_ns - self._shifts[bisect_right(self.begins, time_ns)]
