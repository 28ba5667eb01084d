# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a vehicle's telemetry: position, attitude, gimbal, height, water level.

They name each value's reference, unit and clock, never offsets found by trial: `config/vehicles/`
has them for common vehicles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.config.schema import key

NAN = math.nan
_STAMP = (
    "header: the message's own stamp; arrival: when it arrived (headerless topics always); "
    "px4_us: `timestamp` of px4_msgs, microseconds of the agent's clock."
)
_CLOCKS = ("header", "arrival", "px4_us")
_MAX_GAP = (
    "Samples farther apart than this are not interpolated; the detection is refused. Between "
    "others the covariance holds what the platform may have done."
)
_LATENCY = (
    "Delay from measurement to stamp of this input, relative to the orientations; negative for "
    "early stamps. 0.1 s at 5 m/s is 0.5 m."
)
_WORLD = "World axes of the message: enu, ned (PX4, MAVLink) or nwu (ANAFI)."
_BODY = "Body axes of the message: flu, or frd (PX4, MAVLink)."
_NORTH = (
    "magnetic: yaw is measured from magnetic north and corrected by the World Magnetic Model. "
    "Wrong by 10 deg of declination is wrong by 5 m at 30 m range."
)

HEADERLESS = ("float64", "float32", "mavros_mount")
"""Types that carry no stamp at all."""
PX4 = "px4_"
"""Types of px4_msgs begin with it: their stamp is px4_us, their axes are NED and FRD."""


@dataclass(frozen=True)
class FixConfig:
    """The drone's GNSS position."""

    source: str = key(
        "topic", "topic, or constant for a camera on a mast.", choices=("topic", "constant")
    )
    topic: str = key("fix", "Position topic, relative to the namespace.")
    type: str = key(
        "navsatfix",
        "navsatfix: sensor_msgs/NavSatFix; anafi_fix: the same with its covariance in the order "
        "latitude, longitude; geo_pose: geographic_msgs/GeoPoseStamped; px4_global_position, "
        "px4_sensor_gps: px4_msgs/VehicleGlobalPosition, SensorGps.",
        choices=("navsatfix", "anafi_fix", "geo_pose", "px4_global_position", "px4_sensor_gps"),
    )
    stamp: str = key("header", _STAMP, choices=_CLOCKS)
    max_gap: float = key(2.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    latency_s: float = key(0.0, _LATENCY, unit="s", low=-3.0, high=3.0)
    find_latency: bool = key(
        True,
        "Find out in flight whether the fix has another latency than latency_s, up to 0.5 s more "
        "or less. False: latency_s is taken for exact.",
    )
    altitude_datum: str = key(
        "unknown",
        "Datum of the fix's altitude: ellipsoid (WGS84), amsl (mean sea level; converted with "
        "EGM96), home (take-off point, see home_altitude_m). With unknown, published altitudes "
        "are NaN (robot_localization drops such fixes) and height is required. Sea level and "
        "ellipsoid differ by up to 107 m.",
        choices=("ellipsoid", "amsl", "home", "unknown"),
    )
    home_altitude_m: float = key(
        NAN,
        "Altitude of the take-off point above the ellipsoid, for altitude_datum: home. NaN: "
        "published altitudes are NaN.",
        unit="m",
        low=-500.0,
        high=10000.0,
        optional=True,
    )
    latitude_deg: float = key(
        NAN, "Latitude with source: constant.", unit="deg", low=-90.0, high=90.0, optional=True
    )
    longitude_deg: float = key(
        NAN, "Longitude with source: constant.", unit="deg", low=-180.0, high=180.0, optional=True
    )
    altitude_m: float = key(
        NAN,
        "Altitude with source: constant, in altitude_datum.",
        unit="m",
        low=-500.0,
        high=10000.0,
        optional=True,
    )


@dataclass(frozen=True)
class AttitudeConfig:
    """The drone's body in the world."""

    source: str = key(
        "topic", "topic, or constant for a camera on a mast.", choices=("topic", "constant")
    )
    topic: str = key("attitude", "Attitude topic, relative to the namespace.")
    type: str = key(
        "imu",
        "imu: sensor_msgs/Imu; quaternion, vector3, pose: geometry_msgs/QuaternionStamped, "
        "Vector3Stamped (roll, pitch, yaw), PoseStamped; geo_pose: geographic_msgs/GeoPoseStamped; "
        "px4_attitude: px4_msgs/VehicleAttitude.",
        choices=("imu", "quaternion", "vector3", "pose", "geo_pose", "px4_attitude"),
    )
    stamp: str = key("header", _STAMP, choices=_CLOCKS)
    max_gap: float = key(2.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    world: str = key("enu", _WORLD, choices=("enu", "ned", "nwu"))
    body: str = key("flu", _BODY, choices=("flu", "frd"))
    unit: str = key("rad", "Unit of the angles of type vector3.", choices=("rad", "deg"))
    north: str = key("true", _NORTH, choices=("true", "magnetic"))
    rpy_deg: tuple[float, ...] = key(
        (0.0, 0.0, 0.0),
        "Roll, pitch, yaw (FLU in ENU) with source: constant.",
        unit="deg",
        low=-360.0,
        high=360.0,
        length=3,
    )


@dataclass(frozen=True)
class GimbalConfig:
    """The camera's orientation; camera FLU, straight down is pitch +90 deg."""

    source: str = key(
        "topic",
        "topic; tf (base_frame to camera_frame on /tf and /tf_static); or constant (rpy_deg "
        "below).",
        choices=("topic", "tf", "constant"),
    )
    topic: str = key("gimbal", "Gimbal topic, relative to the namespace.")
    base_frame: str = key(
        "base_link",
        "With source: tf, the frame that reference names: body: the airframe, FLU (REP 103); "
        "heading: base_footprint or a stabilised frame; earth: a frame with ENU axes such as odom.",
    )
    camera_frame: str = key("camera_optical_frame", "With source: tf, the camera's frame.")
    camera_axes: str = key(
        "suffix",
        "Axes of camera_frame. suffix: optical (right, down, forward) if its name ends with "
        "_optical or _optical_frame (REP 103), else flu. Wrong axes are a camera that looks "
        "elsewhere by 90 deg.",
        choices=("suffix", "optical", "flu"),
    )
    type: str = key(
        "quaternion",
        "quaternion, vector3: geometry_msgs/QuaternionStamped, Vector3Stamped (roll, pitch, yaw); "
        "mavros_gimbal, px4_gimbal: GimbalDeviceAttitudeStatus of mavros_msgs, px4_msgs; "
        "mavros_mount: geometry_msgs/Quaternion without header; psdk_gimbal: Vector3Stamped of "
        "psdk_ros2, whose yaw is 0.012 deg too large (1.571 for pi/2).",
        choices=(
            "quaternion",
            "vector3",
            "mavros_gimbal",
            "mavros_mount",
            "px4_gimbal",
            "psdk_gimbal",
        ),
    )
    stamp: str = key("header", _STAMP, choices=_CLOCKS)
    max_gap: float = key(2.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    reference: str = key(
        "earth",
        "Reference of the angles. earth: the world; heading: level, yaw from the nose; body: the "
        "airframe; fixed: no gimbal, mount_rpy_deg in the body; mavlink_flags: from the flags of "
        "each message. A wrong reference causes errors of metres as soon as the drone tilts or "
        "turns.",
        choices=("earth", "heading", "body", "fixed", "mavlink_flags"),
    )
    world: str = key(
        "enu", _WORLD + " For angles relative to earth.", choices=("enu", "ned", "nwu")
    )
    body: str = key(
        "flu",
        _BODY + " Of the camera, and of the vehicle where angles are relative to it.",
        choices=("flu", "frd"),
    )
    unit: str = key("rad", "Unit of the angles of type vector3.", choices=("rad", "deg"))
    north: str = key(
        "true", _NORTH + " For angles relative to earth.", choices=("true", "magnetic")
    )
    mount_rpy_deg: tuple[float, ...] = key(
        (0.0, 0.0, 0.0),
        "With reference: fixed, the camera in the body: roll, pitch, yaw (FLU); straight down "
        "is 0, 90, 0.",
        unit="deg",
        low=-360.0,
        high=360.0,
        length=3,
    )
    rpy_deg: tuple[float, ...] = key(
        (0.0, 90.0, 0.0),
        "Roll, pitch, yaw with source: constant, in the reference (FLU; earth: in ENU).",
        unit="deg",
        low=-360.0,
        high=360.0,
        length=3,
        optional=True,
    )


@dataclass(frozen=True)
class HeightConfig:
    """The drone above the water."""

    source: str = key(
        "topic",
        "topic; constant (value_m below); none: fix altitude less surface.altitude.",
        choices=("topic", "constant", "none"),
    )
    topic: str = key("height", "Height topic, relative to the namespace.")
    type: str = key(
        "float64",
        "float64, float32 (std_msgs); range (sensor_msgs/Range); pose: z of "
        "geometry_msgs/PoseStamped; px4_local_position, px4_dist_bottom: -z or the valid "
        "dist_bottom of px4_msgs/VehicleLocalPosition.",
        choices=("float64", "float32", "range", "pose", "px4_local_position", "px4_dist_bottom"),
    )
    stamp: str = key(
        "arrival",
        _STAMP + " std_msgs numbers carry no stamp.",
        choices=_CLOCKS,
    )
    max_gap: float = key(2.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    latency_s: float = key(0.0, _LATENCY, unit="s", low=-3.0, high=3.0)
    reference: str = key(
        "water",
        "water: above the water; home: above the take-off point, give water_level relative to "
        "it. Wrong by 1 m is wrong by 1.7 m at 60 deg off nadir.",
        choices=("water", "home"),
    )
    along: str = key(
        "vertical",
        "vertical; or body: along the airframe's down axis, as a range finder without correction "
        "measures it. Then attitude is required; 15 deg of tilt are 3.5 % of the height.",
        choices=("vertical", "body"),
    )
    home_topic: str = key(
        "",
        "Topic of the take-off point's altitude, of the same type and datum as topic, which is "
        "then an altitude: their difference is the height above home. Empty: topic is a height.",
    )
    value_m: float = key(
        NAN, "Height with source: constant.", unit="m", low=0.1, high=5000.0, optional=True
    )


@dataclass(frozen=True)
class WaterLevelConfig:
    """Water level above the height's reference (tide); held until the next message."""

    topic: str = key("water_level", "std_msgs/Float64 topic, relative to the namespace.")
    value_m: float = key(
        0.0,
        "Level before the first message; a new value holds until the next one.",
        unit="m",
        low=-500.0,
        high=10000.0,
        dynamic=True,
    )
