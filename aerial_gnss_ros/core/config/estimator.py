# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""All parameters of the estimator, and their mutual consistency."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from aerial_gnss_ros.core.config.corrections import CalibrationConfig, DepthConfig
from aerial_gnss_ros.core.config.fleet import SightingsConfig, check_drone
from aerial_gnss_ros.core.config.limits import LimitsConfig
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.config.processing import (
    CameraConfig,
    DetectionsConfig,
    MapConfig,
    SurfaceConfig,
    TracksConfig,
    UpdatesConfig,
)
from aerial_gnss_ros.core.config.references import Reference, references
from aerial_gnss_ros.core.config.robot_bindings import RobotBinding, robot_bindings
from aerial_gnss_ros.core.config.robot_classes import RobotClass, robot_classes
from aerial_gnss_ros.core.config.schema import build, flatten, group, key
from aerial_gnss_ros.core.config.telemetry import (
    HEADERLESS,
    PX4,
    AttitudeConfig,
    FixConfig,
    GimbalConfig,
    HeightConfig,
    WaterLevelConfig,
)
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import cut, shown

__all__ = [
    "AttitudeConfig",
    "CalibrationConfig",
    "CameraConfig",
    "DepthConfig",
    "DetectionsConfig",
    "EstimatorConfig",
    "FixConfig",
    "GimbalConfig",
    "HeightConfig",
    "LimitsConfig",
    "MapConfig",
    "Reference",
    "RobotBinding",
    "SightingsConfig",
    "SurfaceConfig",
    "TracksConfig",
    "UpdatesConfig",
    "WaterLevelConfig",
    "estimator_config",
]


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
        unit="s",
        low=0.0,
        high=30.0,
    )
    state_file: str = key(
        "",
        "File that keeps labels over a restart, such as a change of batteries; empty: none. "
        "`aerial-gnss run` and the launch file keep them over the restart of a node in any case.",
    )
    start_radius_m: float = key(
        10.0,
        "Distance from its start within which a confirmed robot gets the bound label.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    camera: CameraConfig = group(CameraConfig)
    fix: FixConfig = group(FixConfig)
    attitude: AttitudeConfig = group(AttitudeConfig)
    gimbal: GimbalConfig = group(GimbalConfig)
    height: HeightConfig = group(HeightConfig)
    water_level: WaterLevelConfig = group(WaterLevelConfig)
    limits: LimitsConfig = group(LimitsConfig)
    surface: SurfaceConfig = group(SurfaceConfig)
    depth: DepthConfig = group(DepthConfig)
    calibration: CalibrationConfig = group(CalibrationConfig)
    detections: DetectionsConfig = group(DetectionsConfig)
    tracks: TracksConfig = group(TracksConfig)
    map: MapConfig = group(MapConfig)
    updates: UpdatesConfig = group(UpdatesConfig)
    sightings: SightingsConfig = group(SightingsConfig)
    noise: Noise = group(Noise)
    robots: tuple[RobotBinding, ...] = field(default=())
    classes: tuple[tuple[str, RobotClass], ...] = field(default=())
    references: tuple[Reference, ...] = field(default=())

    def robot_class(self, class_id: str) -> RobotClass:
        """Return the parameters of a class, which default to the global ones."""
        own = dict(self.classes).get(class_id, RobotClass())
        given = (own.max_speed, own.acceleration, own.coast_s)
        default = (
            self.tracks.max_speed,
            self.noise.value("robot_acceleration"),
            self.tracks.coast_s,
        )
        both = zip(given, default, strict=True)
        speed, acceleration, coast_s = (other if math.isnan(one) else one for one, other in both)
        return RobotClass(speed, acceleration, coast_s, own.length_m)

    @property
    def needs_attitude(self) -> bool:
        """Whether the gimbal's reference, a lever arm or a range finder needs the body."""
        ranged = self.height.source == "topic" and self.height.along == "body"
        return self.gimbal.reference != "earth" or ranged or any(self.camera.offset_m)


def estimator_config(values: Mapping[str, Any]) -> EstimatorConfig:
    """Return the estimator's parameters from nested or dotted values.

    Args:
        values: as in config/estimator.yaml; `robots` maps names to `class` and `start`
            ([latitude, longitude] in degrees), `classes` maps classes to `RobotClass`, `references`
            names to `Reference`.

    Raises:
        ConfigError: unknown key, wrong type, out of range, or contradictory keys.
    """
    flat = flatten(values)
    robots = {name: value for name, value in flat.items() if name.startswith("robots.")}
    classes = {name: value for name, value in flat.items() if name.startswith("classes.")}
    known = {name: value for name, value in flat.items() if name.startswith("references.")}
    for name in ("robots", "classes", "references"):
        if flat.get(name) not in (None, {}):
            raise ConfigError(f"{name} must hold names with their keys, not {shown(flat[name])}.")
    free = {*robots, *classes, *known, "robots", "classes", "references"}
    rest = {name: value for name, value in flat.items() if name not in free}
    config = replace(build(EstimatorConfig, rest), robots=robot_bindings(robots))
    config = replace(config, classes=robot_classes(classes, config.detections.classes))
    config = replace(config, references=references(known, config.detections.classes))
    _check_together(config)
    return config


def _check_clocks(config: EstimatorConfig) -> None:
    """Refuse a clock that an input's messages do not carry."""
    for name in ("fix", "attitude", "gimbal", "height"):
        group_ = getattr(config, name)
        kind, stamp = group_.type, group_.stamp
        px4 = kind.startswith(PX4)
        fits = ("arrival", "px4_us") if px4 else ("arrival",)
        if group_.source != "topic" or stamp in fits:
            continue
        if kind in HEADERLESS:
            raise ConfigError(
                f"{name}.stamp is {stamp}, but {kind} messages carry no stamp; use arrival."
            )
        if px4 or stamp == "px4_us":
            instead = "px4_us or arrival" if px4 else "header or arrival"
            raise ConfigError(
                f"{name}.stamp is {stamp}, which {kind} messages do not carry; use {instead}."
            )


def _check_axes(config: EstimatorConfig) -> None:
    """Refuse axes and references that contradict the type of message."""
    fix, gimbal = config.fix, config.gimbal
    for name, group_ in (("attitude", config.attitude), ("gimbal", gimbal)):
        if group_.source == "tf":
            continue  # its axes are those of REP 103
        kind = group_.type
        autopilot = kind.startswith((PX4, "mavros_"))
        wanted = ("ned", "frd") if autopilot else ("enu", "flu")
        if (autopilot or kind == "psdk_gimbal") and (group_.world, group_.body) != wanted:
            raise ConfigError(
                f"{name}.type is {kind}, whose axes are {wanted[0]} and {wanted[1]}; set "
                f"{name}.world: {wanted[0]} and {name}.body: {wanted[1]}."
            )
    flagged = gimbal.type in ("mavros_gimbal", "px4_gimbal") and gimbal.source == "topic"
    if gimbal.reference == "mavlink_flags" and not flagged:
        raise ConfigError(
            f"gimbal.reference is mavlink_flags, but {gimbal.type} messages carry no flags; set "
            "it to earth, heading, body or fixed."
        )
    if fix.type.startswith(PX4) and fix.altitude_datum not in ("ellipsoid", "amsl"):
        raise ConfigError(
            f"fix.type is {fix.type}, which has an altitude above the ellipsoid and one above "
            "mean sea level; set fix.altitude_datum to ellipsoid or amsl."
        )


def _check_together(config: EstimatorConfig) -> None:
    config.depth.by_class()
    config.depth.by_topic()
    classes = config.detections.classes
    for robot in config.robots:
        if classes and robot.class_id not in classes:
            raise ConfigError(
                f"robots.{cut(robot.name)}.class is {shown(robot.class_id)}, which "
                f"detections.classes ({', '.join(map(cut, classes))}) refuses; give one of "
                "these, or add it there."
            )
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
    if config.gimbal.source == "constant" and any(map(math.isnan, config.gimbal.rpy_deg)):
        raise ConfigError("gimbal.source is constant, so gimbal.rpy_deg must be given.")
    if config.height.source == "constant" and math.isnan(config.height.value_m):
        raise ConfigError("height.source is constant, so height.value_m must be given.")
    if config.height.source == "none":
        if math.isnan(config.surface.altitude):
            raise ConfigError("height.source is none, so surface.altitude must be given.")
        if fix.altitude_datum == "unknown":
            raise ConfigError(
                "height.source is none, so fix.altitude_datum must say what surface.altitude and "
                "the fix's altitude are measured from."
            )
    gimbal = config.gimbal
    if gimbal.source == "tf" and (
        not gimbal.base_frame or not gimbal.camera_frame or gimbal.base_frame == gimbal.camera_frame
    ):
        raise ConfigError(
            "gimbal.source is tf, so gimbal.base_frame and gimbal.camera_frame must be two frames, "
            f"not {shown(gimbal.base_frame)} and {shown(gimbal.camera_frame)}."
        )
    _check_clocks(config)
    _check_axes(config)
    _check_map(config)
    check_drone(config.sightings.drone)


def _check_map(config: EstimatorConfig) -> None:
    """Refuse half an origin of map, and one too far from a camera on a mast."""
    map_, fix = config.map, config.fix
    if map_.frame and not re.fullmatch(r"[A-Za-z0-9_.~-]+(/[A-Za-z0-9_.~-]+)*", map_.frame):
        raise ConfigError(
            f"map.frame {shown(map_.frame)} cannot be a frame: use letters, digits and _, with "
            "single / between, and none at the ends."
        )
    if math.isnan(map_.latitude_deg) != math.isnan(map_.longitude_deg):
        raise ConfigError("map.latitude_deg and map.longitude_deg must be given together.")
    if fix.source != "constant" or math.isnan(map_.latitude_deg):
        return
    places = (map_.latitude_deg, map_.longitude_deg, fix.latitude_deg, fix.longitude_deg)
    away, _, _ = geodesic_inverse(*map(math.radians, places))
    if away > config.limits.origin_distance_m:
        raise ConfigError(
            f"The origin of map ({map_.latitude_deg:.7g}, {map_.longitude_deg:.7g}) is "
            f"{away * 1e-3:,.0f} km from the camera (fix.latitude_deg, fix.longitude_deg): correct "
            "map.latitude_deg and map.longitude_deg, or leave them out."
        )
