# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PX4 over uXRCE-DDS (px4_msgs). Releases differ: fields that were added or removed are optional.

Everything is NED and FRD; quaternions are w, x, y, z; stamps are microseconds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import axes, mavlink
from aerial_gnss_ros.core.config.telemetry import (
    AttitudeConfig,
    FixConfig,
    GimbalConfig,
    HeightConfig,
)
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar

FIX_2D = 2  # px4_msgs/SensorGps.fix_type: below it there is no position


def nanoseconds(msg: Any) -> int:
    """Return the stamp of a message of px4_msgs, ns."""
    return int(msg.timestamp) * 1000


def global_position(msg: Any, stamp_ns: int, config: FixConfig) -> Fix:
    """Return a px4_msgs/VehicleGlobalPosition with the altitude of `config.altitude_datum`.

    `lat_lon_valid` and `alt_valid` exist since 1.16; before, PX4 publishes only valid positions.
    """
    altitude = msg.alt if config.altitude_datum == "amsl" else msg.alt_ellipsoid
    return Fix(
        stamp_ns,
        math.radians(msg.lat),
        math.radians(msg.lon),
        float(altitude) if getattr(msg, "alt_valid", True) else math.nan,
        _covariance(float(msg.eph), float(msg.epv)),
        bool(getattr(msg, "lat_lon_valid", True)),
    )


def sensor_gps(msg: Any, stamp_ns: int, config: FixConfig) -> Fix:
    """Return a px4_msgs/SensorGps: degrees and metres since 1.15, before 1e-7 deg and mm."""
    amsl = config.altitude_datum == "amsl"
    if hasattr(msg, "latitude_deg"):
        latitude, longitude = msg.latitude_deg, msg.longitude_deg
        altitude = msg.altitude_msl_m if amsl else msg.altitude_ellipsoid_m
    else:
        latitude, longitude = msg.lat * 1e-7, msg.lon * 1e-7
        altitude = (msg.alt if amsl else msg.alt_ellipsoid) * 1e-3
    return Fix(
        stamp_ns,
        math.radians(latitude),
        math.radians(longitude),
        float(altitude),
        _covariance(float(msg.eph), float(msg.epv)),
        int(msg.fix_type) >= FIX_2D,
    )


def attitude(msg: Any, stamp_ns: int, config: AttitudeConfig) -> Orientation:
    """Return a px4_msgs/VehicleAttitude."""
    return axes.body(_xyzw(msg.q), stamp_ns, config)


def gimbal(msg: Any, stamp_ns: int, config: GimbalConfig) -> Orientation:
    """Return the camera of a px4_msgs/GimbalDeviceAttitudeStatus."""
    return mavlink.gimbal(_xyzw(msg.q), int(msg.device_flags), stamp_ns, config)


def height_above_origin(msg: Any, stamp_ns: int, _config: HeightConfig) -> Scalar:
    """Return the height above the local frame's origin, of a px4_msgs/VehicleLocalPosition."""
    return Scalar(stamp_ns, -float(msg.z) if msg.z_valid else math.nan)


def height_above_bottom(msg: Any, stamp_ns: int, _config: HeightConfig) -> Scalar:
    """Return the range finder's height from PX4's filter, NaN while it is invalid."""
    return Scalar(stamp_ns, float(msg.dist_bottom) if msg.dist_bottom_valid else math.nan)


def _xyzw(wxyz: Any) -> Array:
    w, x, y, z = (float(value) for value in wxyz)
    return np.array([x, y, z, w])


def _covariance(horizontal: float, vertical: float) -> Array | None:
    """Return (3, 3) East, North, Up in m² from standard deviations; None if they are 0: not given.

    Invalid standard deviations (negative, infinite, NaN) make an invalid covariance, so that the
    core refuses the position.
    """
    if horizontal == 0.0:
        return None
    variance = math.copysign(horizontal**2, horizontal)
    return np.diag([variance, variance, vertical**2])
