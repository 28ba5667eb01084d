# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests whether robots are where they were after all clocks were set.

Setting a clock moves no robots, so their tracks continue. A recording that restarts looks the same
but shows another scene. Robots decide: either most of those that were in view are detected at their
predicted positions, or not.
"""

from __future__ import annotations

from collections.abc import Iterable

from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State

TRIAL_NS, TRIAL_IMAGES = 2_000_000_000, 5
"""Time, ns, and number of images with boxes within which robots must be detected again."""


class FoundAgain:
    """Tests the results after a step of time.

    Attributes:
        names: labels of the expected robots; empty without any.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset: expect no robots."""
        self.names: set[str] = set()
        self._first_ns: int | None = None
        self._images = 0

    def expect(self, estimates: Iterable[RobotEstimate]) -> None:
        """Expect the robots that were in view."""
        self.reset()
        self.names = {one.robot_id for one in estimates if one.state is State.CONFIRMED}

    def failed(self, result: FrameResult) -> bool:
        """Update with a result; return whether robots are not where they were.

        Args:
            result: of an image after the step.
        """
        if not self.names or result.pose is None or not result.boxes:
            return False
        seen = {one.robot_id for one in result.estimates if one.state is State.CONFIRMED}
        if 2 * len(seen & self.names) >= min(len(self.names), result.boxes):
            self.reset()
            return False
        if self._first_ns is None:
            self._first_ns = result.stamp_ns
        self._images += 1
        late = result.stamp_ns - self._first_ns > TRIAL_NS
        return late and self._images >= TRIAL_IMAGES
