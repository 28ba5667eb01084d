# SPDX-License-Identifier: Apache-2.0
"""Groups of the estimator's parameters, one a topic of the flight: unit, meaning, consequence."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.parameters import key

NAN = math.nan
_STAMP = "header: the message's own stamp; arrival: when it came (for headerless topics always)."
_MAX_GAP = "Samples farther apart than this are not interpolated; the detection is refused."


@dataclass(frozen=True)
class CameraConfig:
    """The camera and its clock."""

    source: str = key(
        "topic",
        "topic: intrinsics from camera_info; parameters: from focal length and sensor size below.",
        choices=("topic", "parameters"),
    )
    topic: str = key("camera/camera_info", "CameraInfo topic, relative to the namespace.")
    rectified: bool = key(
        False, "True when the images are rectified: uses P and no distortion instead of K and D."
    )
    latency_s: float = key(
        0.0,
        "An image stamped t shows the scene at t - latency_s; late telemetry is negative. Wrong "
        "by 0.1 s at 5 m/s is wrong by 0.5 m.",
        unit="s",
        low=-3.0,
        high=3.0,
    )
    offset_m: tuple[float, ...] = key(
        (0.0, 0.0, 0.0),
        "Camera relative to the GNSS antenna, body forward, left, up. Not zero: attitude is "
        "required.",
        unit="m",
        low=-20.0,
        high=20.0,
        length=3,
    )
    focal_length_mm: float = key(
        NAN,
        "Focal length at the zoom used; only with source: parameters.",
        unit="mm",
        low=0.1,
        high=1000.0,
        optional=True,
    )
    sensor_width_mm: float = key(
        NAN,
        "Width of the sensor that the image covers; only with source: parameters.",
        unit="mm",
        low=0.1,
        high=100.0,
        optional=True,
    )
    sensor_height_mm: float = key(
        NAN,
        "Height of the sensor that the image covers; NaN: square pixels.",
        unit="mm",
        low=0.1,
        high=100.0,
        optional=True,
    )
    image_width_px: int = key(
        0, "Image width; only with source: parameters.", unit="px", low=0, high=20000
    )
    image_height_px: int = key(
        0, "Image height; only with source: parameters.", unit="px", low=0, high=20000
    )


@dataclass(frozen=True)
class FixConfig:
    """The drone's GNSS position."""

    source: str = key(
        "topic", "topic, or constant for a camera on a mast.", choices=("topic", "constant")
    )
    topic: str = key("fix", "NavSatFix topic, relative to the namespace.")
    stamp: str = key("header", _STAMP, choices=("header", "arrival"))
    max_gap: float = key(2.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    altitude_datum: str = key(
        "unknown",
        "What the fix's altitude is measured from. With unknown, published altitudes are NaN "
        "(robot_localization drops such fixes) and height is required.",
        choices=("ellipsoid", "amsl", "home", "unknown"),
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
    """The drone's body, FLU in ENU."""

    source: str = key(
        "topic", "topic, or constant for a camera on a mast.", choices=("topic", "constant")
    )
    topic: str = key("attitude", "Attitude topic, relative to the namespace.")
    type: str = key(
        "imu",
        "imu: sensor_msgs/Imu; quaternion: geometry_msgs/QuaternionStamped.",
        choices=("imu", "quaternion"),
    )
    stamp: str = key("header", _STAMP, choices=("header", "arrival"))
    max_gap: float = key(0.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    north: str = key(
        "true",
        "magnetic: yaw is measured from magnetic north and corrected by the World Magnetic "
        "Model. Wrong by 10 deg of declination is wrong by 5 m at 30 m range.",
        choices=("true", "magnetic"),
    )
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

    source: str = key("topic", "topic, or constant (rpy_deg below).", choices=("topic", "constant"))
    topic: str = key("gimbal", "Gimbal topic, relative to the namespace.")
    type: str = key(
        "quaternion",
        "quaternion: geometry_msgs/QuaternionStamped; vector3: geometry_msgs/Vector3Stamped with "
        "roll, pitch, yaw in rad.",
        choices=("quaternion", "vector3"),
    )
    stamp: str = key("header", _STAMP, choices=("header", "arrival"))
    max_gap: float = key(0.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    reference: str = key(
        "earth",
        "What the angles are relative to. earth: ENU; heading: level, yaw from the nose; body: "
        "the airframe; fixed: no gimbal, mount_rpy_deg in the body. A wrong reference is wrong "
        "by metres as soon as the drone tilts or turns.",
        choices=("earth", "heading", "body", "fixed"),
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
        "Roll, pitch, yaw with source: constant.",
        unit="deg",
        low=-360.0,
        high=360.0,
        length=3,
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
        "float64, float32 (std_msgs) or range (sensor_msgs/Range).",
        choices=("float64", "float32", "range"),
    )
    stamp: str = key(
        "arrival",
        "header is possible with type: range only; std_msgs numbers carry no stamp.",
        choices=("header", "arrival"),
    )
    max_gap: float = key(1.5, _MAX_GAP, unit="s", low=0.001, high=60.0)
    reference: str = key(
        "water",
        "water: above the water; home: above the take-off point, give water_level relative to "
        "it. Wrong by 1 m is wrong by 1.7 m at 60 deg off nadir.",
        choices=("water", "home"),
    )
    value_m: float = key(
        NAN, "Height with source: constant.", unit="m", low=0.1, high=5000.0, optional=True
    )


@dataclass(frozen=True)
class WaterLevelConfig:
    """How far the water stands above the height's reference (tide); held until replaced."""

    topic: str = key("water_level", "std_msgs/Float64 topic, relative to the namespace.")
    value_m: float = key(0.0, "Level before the first message.", unit="m", low=-500.0, high=10000.0)


@dataclass(frozen=True)
class SurfaceConfig:
    """The water's surface."""

    altitude: float = key(
        NAN,
        "Altitude of the water in fix.altitude_datum; used where height.source is none.",
        unit="m",
        low=-500.0,
        high=10000.0,
        optional=True,
    )
    max_range: float = key(
        1000.0,
        "Points farther from the camera are refused as out_of_range: near the horizon a small "
        "angle is a large distance.",
        unit="m",
        low=1.0,
        high=20000.0,
    )
    max_sigma_m: float = key(
        50.0,
        "Points whose own one sigma is larger are refused as out_of_range.",
        unit="m",
        low=0.1,
        high=10000.0,
    )


@dataclass(frozen=True)
class DetectionsConfig:
    """Which boxes are used."""

    topic: str = key("detections", "Detection2DArray topic, relative to the namespace.")
    min_score: float = key(
        0.25, "Boxes below are refused as low_score.", low=0.0, high=1.0, dynamic=True
    )
    classes: tuple[str, ...] = key(
        (), "Class names that are robots; others are refused as wrong_class. Empty: all."
    )


@dataclass(frozen=True)
class TracksConfig:
    """From single positions to robots with names."""

    gate_probability: float = key(
        0.997, "Share of a robot's own measurements that its gate lets in.", low=0.5, high=0.999999
    )
    confirm_hits: int = key(
        3, "Measurements that confirm a tentative track; more is slower and surer.", low=1, high=100
    )
    confirm_window_s: float = key(
        2.0, "Time within which they must come.", unit="s", low=0.05, high=60.0
    )
    coast_s: float = key(
        120.0,
        "A confirmed robot that is not seen coasts this long with growing covariance before it "
        "is lost.",
        unit="s",
        low=0.0,
        high=3600.0,
    )
    max_speed: float = key(
        1.5,
        "Fastest speed over ground of a robot; one sigma of the first velocity is half of it.",
        unit="m/s",
        low=0.01,
        high=50.0,
    )


@dataclass(frozen=True)
class MapConfig:
    """Origin of the local ENU frame `map`; NaN: the first accepted fix."""

    latitude_deg: float = key(
        NAN, "Latitude of the origin.", unit="deg", low=-90.0, high=90.0, optional=True
    )
    longitude_deg: float = key(
        NAN, "Longitude of the origin.", unit="deg", low=-180.0, high=180.0, optional=True
    )
    altitude_m: float = key(
        NAN,
        "Ellipsoidal altitude of the origin.",
        unit="m",
        low=-500.0,
        high=10000.0,
        optional=True,
    )
