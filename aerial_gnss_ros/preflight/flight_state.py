# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The drone's state at one time, sampled for checks before a flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.core.values.samples import Fix

Array = NDArray[np.float64]

STEP_NS = 200_000_000
"""Time between two states, ns."""


@dataclass(frozen=True)
class FlightState:
    """State of the drone at one time; None if unknown.

    Attributes:
        stamp_ns: ns.
        fix: its position.
        body: (3, 3) body FLU in ENU (true north).
        height: above the height's reference, m.
        pose: of the camera.
        reason: why there is no pose.
    """

    stamp_ns: int
    fix: Fix | None = None
    body: Array | None = None
    height: float | None = None
    pose: CameraPose | None = None
    reason: Reason | None = None
