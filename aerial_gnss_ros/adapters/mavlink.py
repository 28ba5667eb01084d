# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reference of MAVLink's GIMBAL_DEVICE_ATTITUDE_STATUS, from its flags.

Its quaternion is FRD in a level frame whose x axis points north or along the vehicle's nose; roll
and pitch are always from the horizon (MAVLink common.xml, message 285).
"""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.adapters import axes
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.values.samples import Array, Orientation

# GIMBAL_DEVICE_FLAGS
YAW_LOCK = 16
YAW_IN_VEHICLE_FRAME = 32
YAW_IN_EARTH_FRAME = 64


def reference(flags: int) -> str:
    """Return `earth` or `heading`, or None if the flags contradict each other.

    Older devices set neither frame flag: then YAW_LOCK means that yaw is earth-referenced.
    """
    earth, vehicle = bool(flags & YAW_IN_EARTH_FRAME), bool(flags & YAW_IN_VEHICLE_FRAME)
    if earth and vehicle:
        return ""
    if earth or vehicle:
        return "earth" if earth else "heading"
    return "earth" if flags & YAW_LOCK else "heading"


def gimbal(quaternion: Array, flags: int, stamp_ns: int, config: GimbalConfig) -> Orientation:
    """Return the camera of a GIMBAL_DEVICE_ATTITUDE_STATUS.

    Args:
        quaternion: (4,) x, y, z, w.
        flags: its GIMBAL_DEVICE_FLAGS; ignored if `config.reference` names a frame, because some
            devices set wrong ones.
        stamp_ns: time of validity, ns.
        config: of the gimbal.

    Returns:
        The orientation; NaN, so that the core refuses it, if the flags contradict each other.
    """
    said = reference(flags)
    if config.reference == axes.MAVLINK_FLAGS and not said:
        return Orientation(stamp_ns, np.full(4, np.nan))
    return axes.camera(quaternion, stamp_ns, config, said)
