# SPDX-License-Identifier: Apache-2.0
"""The estimator's parameters: every key with unit, meaning, default and consequence."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from aerial_gnss_ros.core.errors import ConfigError
from aerial_gnss_ros.core.noise import Noise
from aerial_gnss_ros.core.parameters import build, flatten, group, key

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
        unit="s", low=-3.0, high=3.0,
    )
    offset_m: tuple[float, ...] = key(
        (0.0, 0.0, 0.0),
        "Camera relative to the GNSS antenna, body forward, left, up. Not zero: attitude is "
        "required.",
        unit="m", low=-20.0, high=20.0, length=3,
    )
    focal_length_mm: float = key(
        NAN, "Focal length at the zoom used; only with source: parameters.", unit="mm",
        low=0.1, high=1000.0, optional=True,
    )
    sensor_width_mm: float = key(
        NAN, "Width of the sensor that the image covers; only with source: parameters.",
        unit="mm", low=0.1, high=100.0, optional=True,
    )
    sensor_height_mm: float = key(
        NAN, "Height of the sensor that the image covers; NaN: square pixels.", unit="mm",
        low=0.1, high=100.0, optional=True,
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
        NAN, "Altitude with source: constant, in altitude_datum.", unit="m",
        low=-500.0, high=10000.0, optional=True,
    )


@dataclass(frozen=True)
class AttitudeConfig:
    """The drone's body, FLU in ENU."""

    source: str = key(
        "topic", "topic, or constant for a camera on a mast.", choices=("topic", "constant")
    )
    topic: str = key("attitude", "Attitude topic, relative to the namespace.")
    type: str = key(
        "imu", "imu: sensor_msgs/Imu; quaternion: geometry_msgs/QuaternionStamped.",
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
        (0.0, 0.0, 0.0), "Roll, pitch, yaw (FLU in ENU) with source: constant.", unit="deg",
        low=-360.0, high=360.0, length=3,
    )


@dataclass(frozen=True)
class GimbalConfig:
    """The camera's orientation; camera FLU, straight down is pitch +90 deg."""

    source: str = key(
        "topic", "topic, or constant (rpy_deg below).", choices=("topic", "constant")
    )
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
        unit="deg", low=-360.0, high=360.0, length=3,
    )
    rpy_deg: tuple[float, ...] = key(
        (0.0, 90.0, 0.0), "Roll, pitch, yaw with source: constant.", unit="deg",
        low=-360.0, high=360.0, length=3,
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
        "float64", "float64, float32 (std_msgs) or range (sensor_msgs/Range).",
        choices=("float64", "float32", "range"),
    )
    stamp: str = key(
        "arrival", "header is possible with type: range only; std_msgs numbers carry no stamp.",
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
    value_m: float = key(
        0.0, "Level before the first message.", unit="m", low=-500.0, high=10000.0
    )


@dataclass(frozen=True)
class SurfaceConfig:
    """The water's surface."""

    altitude: float = key(
        NAN,
        "Altitude of the water in fix.altitude_datum; used where height.source is none.",
        unit="m", low=-500.0, high=10000.0, optional=True,
    )
    max_range: float = key(
        1000.0,
        "Points farther from the camera are refused as out_of_range: near the horizon a small "
        "angle is a large distance.",
        unit="m", low=1.0, high=20000.0,
    )
    max_sigma_m: float = key(
        50.0,
        "Points whose own one sigma is larger are refused as out_of_range.",
        unit="m", low=0.1, high=10000.0,
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
        unit="s", low=0.0, high=3600.0,
    )
    max_speed: float = key(
        1.5, "Fastest speed over ground of a robot; one sigma of the first velocity is half of it.",
        unit="m/s", low=0.01, high=50.0,
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
        NAN, "Ellipsoidal altitude of the origin.", unit="m", low=-500.0, high=10000.0,
        optional=True,
    )


@dataclass(frozen=True)
class RobotBinding:
    """A name bound to the robot that is first confirmed near a start.

    Attributes:
        name: the robot's id in topics.
        class_id: class name that the detector gives it.
        latitude: of the start, rad.
        longitude: of the start, rad.
    """

    name: str
    class_id: str
    latitude: float
    longitude: float


@dataclass(frozen=True)
class EstimatorConfig:
    """All parameters of the estimator."""

    method: str = key(
        "filter",
        "filter: tracked over time; single: exact ray, each image alone; paper: the published "
        "equations, as a baseline.",
        choices=("filter", "single", "paper"),
    )
    max_wait: float = key(
        3.0,
        "A detection waits this long for the telemetry that brackets it, then it is refused "
        "with the late input's name.",
        unit="s", low=0.0, high=30.0,
    )
    state_file: str = key("", "File that keeps robot names over a restart; empty: none.")
    start_radius_m: float = key(
        10.0, "How near its start a robot must be confirmed to take the bound name.", unit="m",
        low=0.1, high=1000.0,
    )
    camera: CameraConfig = group(CameraConfig)
    fix: FixConfig = group(FixConfig)
    attitude: AttitudeConfig = group(AttitudeConfig)
    gimbal: GimbalConfig = group(GimbalConfig)
    height: HeightConfig = group(HeightConfig)
    water_level: WaterLevelConfig = group(WaterLevelConfig)
    surface: SurfaceConfig = group(SurfaceConfig)
    detections: DetectionsConfig = group(DetectionsConfig)
    tracks: TracksConfig = group(TracksConfig)
    map: MapConfig = group(MapConfig)
    noise: Noise = group(Noise)
    robots: tuple[RobotBinding, ...] = field(default=())

    @property
    def needs_attitude(self) -> bool:
        """Whether the gimbal's reference or a lever arm needs the body's orientation."""
        return self.gimbal.reference != "earth" or any(self.camera.offset_m)


def estimator_config(values: Mapping[str, Any]) -> EstimatorConfig:
    """Return the estimator's parameters from nested or dotted values.

    Args:
        values: as in config/estimator.yaml; `robots` maps names to `class` and `start`
            ([latitude, longitude] in degrees).

    Raises:
        ConfigError: unknown key, wrong type, out of range, or keys that contradict one another.
    """
    flat = flatten(values)
    robots = {name: value for name, value in flat.items() if name.startswith("robots.")}
    rest = {name: value for name, value in flat.items() if name not in robots and name != "robots"}
    config = replace(build(EstimatorConfig, rest), robots=_bindings(robots))
    _check_together(config)
    return config


def _bindings(flat: Mapping[str, Any]) -> tuple[RobotBinding, ...]:
    names: dict[str, dict[str, Any]] = {}
    for dotted, value in flat.items():
        parts = dotted.split(".")
        if len(parts) != 3 or parts[2] not in ("class", "start"):
            raise ConfigError(f"{dotted} is not a parameter; robots.<name> has class and start.")
        names.setdefault(parts[1], {})[parts[2]] = value
    return tuple(_binding(name, values) for name, values in sorted(names.items()))


def _binding(name: str, values: Mapping[str, Any]) -> RobotBinding:
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise ConfigError(
            f"robots.{name} cannot be a topic name; use lower-case letters, digits and _, and "
            "begin with a letter."
        )
    class_id, start = values.get("class"), values.get("start")
    if not isinstance(class_id, str) or not class_id:
        raise ConfigError(f"robots.{name}.class must be the name of a class, not {class_id!r}.")
    numbers = list(start) if hasattr(start, "__iter__") and not isinstance(start, str) else []
    if len(numbers) != 2 or not all(
        isinstance(n, int | float) and not isinstance(n, bool) for n in numbers
    ):
        raise ConfigError(
            f"robots.{name}.start must be [latitude, longitude] in degrees, not {start!r}."
        )
    latitude, longitude = float(numbers[0]), float(numbers[1])
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        raise ConfigError(f"robots.{name}.start {numbers} is not a place on Earth.")
    return RobotBinding(name, class_id, math.radians(latitude), math.radians(longitude))


def _check_together(config: EstimatorConfig) -> None:
    camera, fix = config.camera, config.fix
    if camera.source == "parameters" and (
        math.isnan(camera.focal_length_mm)
        or math.isnan(camera.sensor_width_mm)
        or not camera.image_width_px
        or not camera.image_height_px
    ):
        raise ConfigError(
            "camera.source is parameters, so camera.focal_length_mm, camera.sensor_width_mm, "
            "camera.image_width_px and camera.image_height_px must all be given."
        )
    if fix.source == "constant" and (math.isnan(fix.latitude_deg) or math.isnan(fix.longitude_deg)):
        raise ConfigError(
            "fix.source is constant, so fix.latitude_deg and fix.longitude_deg must be given."
        )
    if config.height.source == "constant" and math.isnan(config.height.value_m):
        raise ConfigError("height.source is constant, so height.value_m must be given.")
    if config.height.stamp == "header" and config.height.type != "range":
        raise ConfigError(
            f"height.stamp is header, but {config.height.type} messages carry no stamp; use "
            "arrival."
        )
    if config.height.source == "none":
        if math.isnan(config.surface.altitude):
            raise ConfigError("height.source is none, so surface.altitude must be given.")
        if fix.altitude_datum == "unknown":
            raise ConfigError(
                "height.source is none, so fix.altitude_datum must say what surface.altitude and "
                "the fix's altitude are measured from."
            )
    if math.isnan(config.map.latitude_deg) != math.isnan(config.map.longitude_deg):
        raise ConfigError("map.latitude_deg and map.longitude_deg must be given together.")
