# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scene mismatch: images that contradict most robots contradict the platform, and update none.

A rotating compass or a jump displaces robots' boxes onto other robots: the few that fall into a
gate do so by chance. Whether robots are displaced or only missed is weighed by the rates of missed
robots and false boxes (`displaced_robots`).
"""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.association.clutter import Clutter
from aerial_gnss_ros.core.association.displaced_robots import DisplacedRobots


@dataclass(frozen=True)
class SceneMismatchTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    majority_robots: int = 3
    """Number of robots in view from which a majority must agree with an image; of two, one must.
    Judged."""


TUNING = SceneMismatchTuning()


@dataclass(frozen=True)
class RobotsSeen:
    """What an image shows of the robots.

    Attributes:
        in_view: number of robots expected in the image, and not at its edge.
        matched: number of these that have a box.
        unclaimed: number of boxes that no robot has.
    """

    in_view: int
    matched: int
    unclaimed: int

    @property
    def known(self) -> int:
        """Number of robots of which the image tells whether they are where they are expected."""
        return min(self.in_view, self.matched + self.unclaimed)

    @property
    def contradicts(self) -> bool:
        """Whether most of them are not."""
        return self.known > 1 and 2 * self.matched < self.known


class SceneMismatch:
    """Whether images contradict most robots, followed from one image to the next.

    Attributes:
        active: whether an image contradicted most robots, and they have not been reacquired since.
        sentence: about the last image, for the log; may be empty.
    """

    def __init__(self) -> None:
        self.active, self.sentence = False, ""
        self._displaced = DisplacedRobots()
        self._reported = False
        self._agreed = 0

    def expect(self) -> None:
        """Begin: telemetry tells that robots will be displaced."""
        self.active, self._agreed = True, 0

    def end(self) -> None:
        """End: robots have been found again."""
        self.active = False
        self._displaced.reset()

    def update(self, rates: Clutter, seen: RobotsSeen, passed_s: float) -> bool:
        """Update with an image; return whether it contradicts most robots, and updates none.

        Args:
            rates: of missed robots and of false boxes.
            seen: what it shows.
            passed_s: time since the last image, s.
        """
        contradicts, self.sentence = seen.contradicts, ""
        if contradicts and not self.active:
            contradicts = self._displaced.update(
                rates, seen.in_view, seen.matched, seen.unclaimed, passed_s
            )
        elif seen.matched:
            self._displaced.reset()
        if seen.known < TUNING.majority_robots and not contradicts:
            # Of few robots, all must be reacquired, in more than one image.
            self._agreed = self._agreed + seen.matched if 0 < seen.matched == seen.known else 0
            self.active = self.active and self._agreed < TUNING.majority_robots
            return False
        self._agreed = 0
        if contradicts and self.active and not self._reported:  # one image may be in error
            self._reported = True
            self.sentence = (
                f"{seen.known - seen.matched} of {seen.known} boxes are not where robots are "
                "expected: the compass, the gimbal or the fix may be wrong; such images update no "
                "robot."
            )
        self.active = contradicts
        self._reported &= contradicts
        return contradicts
