# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The final message of a lost robot, which its latched topic keeps for later subscribers.

Without it, the topic would keep the last estimate, whose covariance was valid at its stamp only.
The final message has the state LOST (NO_FIX in NavSatFix), the last estimated position, and a
covariance of a kilometre: unknown.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.adapters.map_frame import UNKNOWN_LENGTH_M2
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State


class Departures:
    """Remembers published robots and adds the final message of those whose tracks end."""

    def __init__(self) -> None:
        self._present: dict[str, RobotEstimate] = {}

    @property
    def present(self) -> tuple[RobotEstimate, ...]:
        """The robots of the newest result, in its order."""
        return tuple(self._present.values())

    def completed(self, result: FrameResult) -> FrameResult:
        """Return a result with the robots that only the previous one had added as lost."""
        present = {estimate.robot_id: estimate for estimate in result.estimates}
        gone = [one for name, one in self._present.items() if name not in present]
        self._present = present
        if not gone:
            return result
        ended = tuple(lost(estimate, result.stamp_ns) for estimate in gone)
        return replace(result, estimates=(*result.estimates, *ended))


def lost(estimate: RobotEstimate, stamp_ns: int) -> RobotEstimate:
    """Return the last estimate of a robot whose track ended.

    Args:
        estimate: the newest one published.
        stamp_ns: time from which the robot is lost, ns.
    """
    return replace(
        estimate,
        stamp_ns=stamp_ns,
        state=State.LOST,
        velocity=np.full(2, np.nan),
        covariance=np.diag(np.full(4, UNKNOWN_LENGTH_M2)),
    )
