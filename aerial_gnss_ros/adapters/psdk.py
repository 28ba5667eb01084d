# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""DJI through psdk_ros2. Only its gimbal message is not canonical."""

from __future__ import annotations

import math
from typing import Any

from aerial_gnss_ros.adapters import axes
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.values.samples import Orientation

NORTH_TO_EAST = 1.571  # psdk_ros2 uses this for pi/2, so its yaw is 0.012 deg too large


def gimbal(msg: Any, stamp_ns: int, config: GimbalConfig) -> Orientation:
    """Return the camera of `psdk_ros2/gimbal_angles`: roll, pitch, yaw in rad, FLU in ENU."""
    angles = msg.vector
    yaw = float(angles.z) - (NORTH_TO_EAST - 0.5 * math.pi)
    quaternion = axes.from_angles(float(angles.x), float(angles.y), yaw)
    return axes.camera(quaternion, stamp_ns, config)
