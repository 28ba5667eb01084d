# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The time for which the camera has moved or turned: only then do images tell a latency."""

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
