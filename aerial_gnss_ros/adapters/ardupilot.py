# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ArduPilot's own DDS client: the fused pose of `/ap/geopose/filtered` and `/ap/pose/filtered`.

It publishes no gimbal. `/ap/imu/experimental/data` is not read: its quaternion has its components
in the wrong places.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import axes
from aerial_gnss_ros.core.config.telemetry import AttitudeConfig, FixConfig, HeightConfig
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar


def geo_position(msg: Any, stamp_ns: int, _config: FixConfig) -> Fix:
    """Return the position of a geographic_msgs/GeoPoseStamped; it has no status and no covariance.

    ArduPilot's altitude is above mean sea level, contrary to that message's definition.
    """
    at = msg.pose.position
    return Fix(stamp_ns, math.radians(at.latitude), math.radians(at.longitude), float(at.altitude))


def pose_orientation(msg: Any, stamp_ns: int, config: AttitudeConfig) -> Orientation:
    """Return the body of a geographic_msgs/GeoPoseStamped or geometry_msgs/PoseStamped."""
    q = msg.pose.orientation
    return axes.body(np.array([q.x, q.y, q.z, q.w], dtype=np.float64), stamp_ns, config)


def pose_height(msg: Any, stamp_ns: int, _config: HeightConfig) -> Scalar:
    """Return z of a geometry_msgs/PoseStamped, which is above home."""
    return Scalar(stamp_ns, float(msg.pose.position.z))
