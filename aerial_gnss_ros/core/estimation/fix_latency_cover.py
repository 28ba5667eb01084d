# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""By how much positions are less certain while the fix may have another latency.

A late fix moves the camera, and robots with it. What remains of that depends on the flight: around
a circle an error of the compass explains the same boxes, and robots near the centre hardly move. So
robots are displaced as the filters of `FixLatencySearch` say, which track them at each latency; one
that these do not track, as its box was.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.estimation.latency_cover import LatencyCover
from aerial_gnss_ros.core.values.estimates import RobotEstimate

Array = NDArray[np.float64]


class FixLatencyCover(LatencyCover):
    """Says what other latencies of the fix make of positions.

    Its candidates are those of `FixLatencySearch`: places of so much earlier.

    Attributes:
        displacements: (h, 2) of tracked robots at each candidate, by label, m.
    """

    displacements: Mapping[str, Array] = {}

    def _displacements(self, estimates: Sequence[RobotEstimate]) -> Array:
        """Return how far (h, n, 2) from where they are latencies show n robots, m."""
        places = np.array([one.position[:2] for _, one in self._cameras])
        before = (places - self._camera.position[:2])[:, None]
        found = np.repeat(self._at_latencies(before, -before), len(estimates), axis=1)
        for i, one in enumerate(estimates):
            if one.robot_id in self.displacements:
                found[:, i] = self.displacements[one.robot_id]
        return found
