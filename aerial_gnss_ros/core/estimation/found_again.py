# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots are where they were, after the clock of everything was set.

A clock that is set moves no robot, so that their tracks go on. A recording that begins again shows
another scene under the same sign. Robots tell which it was: most of those that were in view are
found again where they should be, or they are not.
"""

from __future__ import annotations

from collections.abc import Iterable

from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State

TRIAL_NS, TRIAL_IMAGES = 2_000_000_000, 5
"""Robots must be found again within so long, and in so many images with boxes, from the first."""


class FoundAgain:
    """Judges the results after a step.

    Attributes:
        names: of the robots that are expected; empty where none is.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Expect no robots."""
        self.names: set[str] = set()
        self._first_ns: int | None = None
        self._images = 0

    def expect(self, estimates: Iterable[RobotEstimate]) -> None:
        """Expect the robots that were in view again."""
        self.reset()
        self.names = {one.robot_id for one in estimates if one.state is State.CONFIRMED}

    def failed(self, result: FrameResult) -> bool:
        """Take in a result; return whether robots are not where they were.

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
