# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""MAVROS (PX4 and ArduPilot). Its position, attitude and heights are canonical messages.

Only the gimbal is passed through unconverted: FRD axes, MAVLink's signs (camera down is a negative
pitch), whatever its `frame_id`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import axes, mavlink
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.values.samples import Array, Orientation


def gimbal(msg: Any, stamp_ns: int, config: GimbalConfig) -> Orientation:
    """Return the camera of a mavros_msgs/GimbalDeviceAttitudeStatus (gimbal protocol 2)."""
    return mavlink.gimbal(_xyzw(msg.q), int(msg.flags), stamp_ns, config)


def mount(msg: Any, stamp_ns: int, config: GimbalConfig) -> Orientation:
    """Return the camera of `mount_control/orientation`, a geometry_msgs/Quaternion (protocol 1).

    It is Rz(yaw) Ry(pitch) Rx(roll) of MOUNT_ORIENTATION's angles.
    """
    return axes.camera(_xyzw(msg), stamp_ns, config)


def _xyzw(q: Any) -> Array:
    return np.array([q.x, q.y, q.z, q.w], dtype=np.float64)
