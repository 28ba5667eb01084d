# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The time for which the camera has moved or turned: only then do images tell a latency.

After a while of it, images are compared more seldom: most flights have told by then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_vector


@dataclass(frozen=True)
class TimeInMotionTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    moving_mps: float = 0.5
    """A camera that moves more slowly, and turns more slowly than `turning_radps`, says nothing of
    the latency, m/s. Judged."""
    turning_radps: float = math.radians(1.0)
    """The same of its rotation, rad/s. Judged."""
    interval_s: float = 0.4
    """Least time between images that are compared, s: some ten decide, each costs as much as ten in
    the filter, and what fits badly does so for about as long, by one cause. Judged."""
    often_s: float = 60.0
    """Time in motion after which images are compared more seldom, s: most flights have told by
    then. Judged."""
    seldom_s: float = 1.0
    """Least time between images from then on, s. Judged."""


TUNING = TimeInMotionTuning()


class TimeInMotion:
    """Adds up the time in which the camera moves.

    Attributes:
        total_s: that time, s.
    """

    def __init__(self) -> None:
        self.total_s = 0.0
        self._last: tuple[int, MapPose] | None = None

    def interrupt(self) -> None:
        """Count nothing between the last image and the next one."""
        self._last = None

    def update(self, stamp_ns: int, pose: MapPose) -> None:
        """Add the time since the last image if the camera has moved or turned since.

        Args:
            stamp_ns: of the image, ns.
            pose: of the camera.
        """
        before, self._last = self._last, (stamp_ns, pose)
        if before is None or stamp_ns <= before[0]:
            return
        passed_s = (stamp_ns - before[0]) * 1e-9
        way = float(np.linalg.norm(pose.position - before[1].position))
        turn = float(np.linalg.norm(rotation_vector(pose.rotation @ before[1].rotation.T)))
        if way > TUNING.moving_mps * passed_s or turn > TUNING.turning_radps * passed_s:
            self.total_s += passed_s

    @property
    def long(self) -> bool:
        """Whether the camera has moved for a time by which most flights have told."""
        return self.total_s > TUNING.often_s

    @property
    def pause_s(self) -> float:
        """Least time until the next image that is to be compared, s."""
        return TUNING.seldom_s if self.long else TUNING.interval_s
