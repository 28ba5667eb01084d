# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Message types that each input accepts, by their names in the configuration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from aerial_gnss_ros.adapters import anafi, ardupilot, axes, canonical, mavros, psdk, px4
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.config.telemetry import (
    AttitudeConfig,
    FixConfig,
    GimbalConfig,
    HeightConfig,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

Group = TypeVar("Group")
Value = TypeVar("Value")


@dataclass(frozen=True)
class Kind(Generic[Group, Value]):
    """A type of message.

    Attributes:
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        read: converts the message, given its stamp in ns and the input's configuration.
        versioned: whether its topic may end with `_v1`, `_v2`, … (PX4 since 1.16).
    """

    msgtype: str
    read: Callable[[Any, int, Group], Value]
    versioned: bool = False


def stamp_ns(msg: Any, arrival_ns: int, clock: str) -> int:
    """Return a message's time of validity, ns, on the clock that the configuration names."""
    if clock == "arrival":
        return arrival_ns
    return px4.nanoseconds(msg) if clock == "px4_us" else nanoseconds(msg.header.stamp)


def _fix(msg: Any, stamp: int, _config: FixConfig) -> Fix:
    return canonical.fix(msg, stamp)


def _attitude(kind: str) -> Callable[[Any, int, AttitudeConfig], Orientation]:
    def read(msg: Any, stamp: int, config: AttitudeConfig) -> Orientation:
        own = canonical.orientation(msg, stamp, kind, config.unit)
        return axes.body(own.quaternion, stamp, config)

    return read


def _gimbal(kind: str) -> Callable[[Any, int, GimbalConfig], Orientation]:
    def read(msg: Any, stamp: int, config: GimbalConfig) -> Orientation:
        own = canonical.orientation(msg, stamp, kind, config.unit)
        return axes.camera(own.quaternion, stamp, config)

    return read


def _height(msg: Any, stamp: int, _config: HeightConfig) -> Scalar:
    return canonical.scalar(msg, stamp)


def _px4(name: str, read: Callable[[Any, int, Group], Value]) -> Kind[Group, Value]:
    return Kind(f"px4_msgs/msg/{name}", read, versioned=True)


_QUATERNION = "geometry_msgs/msg/QuaternionStamped"
_VECTOR = "geometry_msgs/msg/Vector3Stamped"
_POSE = "geometry_msgs/msg/PoseStamped"
_GEO_POSE = "geographic_msgs/msg/GeoPoseStamped"
_NAVSATFIX = "sensor_msgs/msg/NavSatFix"

FIX: dict[str, Kind[FixConfig, Fix]] = {
    "navsatfix": Kind(_NAVSATFIX, _fix),
    "anafi_fix": Kind(_NAVSATFIX, anafi.fix),
    "geo_pose": Kind(_GEO_POSE, ardupilot.geo_position),
    "px4_global_position": _px4("VehicleGlobalPosition", px4.global_position),
    "px4_sensor_gps": _px4("SensorGps", px4.sensor_gps),
}
ATTITUDE: dict[str, Kind[AttitudeConfig, Orientation]] = {
    "imu": Kind("sensor_msgs/msg/Imu", _attitude("imu")),
    "quaternion": Kind(_QUATERNION, _attitude("quaternion")),
    "vector3": Kind(_VECTOR, _attitude("vector3")),
    "pose": Kind(_POSE, ardupilot.pose_orientation),
    "geo_pose": Kind(_GEO_POSE, ardupilot.pose_orientation),
    "px4_attitude": _px4("VehicleAttitude", px4.attitude),
}
GIMBAL: dict[str, Kind[GimbalConfig, Orientation]] = {
    "quaternion": Kind(_QUATERNION, _gimbal("quaternion")),
    "vector3": Kind(_VECTOR, _gimbal("vector3")),
    "mavros_gimbal": Kind("mavros_msgs/msg/GimbalDeviceAttitudeStatus", mavros.gimbal),
    "mavros_mount": Kind("geometry_msgs/msg/Quaternion", mavros.mount),
    "px4_gimbal": _px4("GimbalDeviceAttitudeStatus", px4.gimbal),
    "psdk_gimbal": Kind(_VECTOR, psdk.gimbal),
}
HEIGHT: dict[str, Kind[HeightConfig, Scalar]] = {
    "float64": Kind("std_msgs/msg/Float64", _height),
    "float32": Kind("std_msgs/msg/Float32", _height),
    "range": Kind("sensor_msgs/msg/Range", _height),
    "pose": Kind(_POSE, ardupilot.pose_height),
    "px4_local_position": _px4("VehicleLocalPosition", px4.height_above_origin),
    "px4_dist_bottom": _px4("VehicleLocalPosition", px4.height_above_bottom),
}
