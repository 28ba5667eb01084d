# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A published estimate as an example of what is written to files."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.values.estimates import RobotEstimate, State

ESTIMATE = RobotEstimate(
    stamp_ns=1_735_689_600_123_456_789,
    robot_id="aqua_1",
    class_id="aqua",
    state=State.COASTING,
    latitude=math.radians(13.19393870329445),
    longitude=math.radians(-59.6415065636197),
    altitude=math.nan,
    position=np.array([1.0, 2.0]),
    velocity=np.array([0.25, -1.0]),
    covariance=np.diag([4.0, 1.0 / 3.0, 1.0, 1.0]) + np.diag([1e-7, 0, 0], 1),
    last_seen_ns=0,
)
