# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of camera, water surface, boxes, tracks and map: unit, meaning, consequence."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.config.schema import key

NAN = math.nan


@dataclass(frozen=True)
class CameraConfig:
    """The camera and its clock."""

    source: str = key(
        "topic",
        "topic: intrinsics from camera_info; parameters: from focal length and sensor size below.",
        choices=("topic", "parameters"),
    )
    topic: str = key("camera/camera_info", "CameraInfo topic, relative to the namespace.")
    stamp: str = key(
        "header",
        "Time of CameraInfo. header: its stamp; arrival: when it arrived, for a driver whose clock "
        "differs from that of the images.",
        choices=("header", "arrival"),
    )
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
        dynamic=True,
    )
    find_latency: bool = key(
        True,
        "Find out in flight whether images come by another latency than latency_s, and estimate it "
        "from then on; robots keep their labels. Covariances contain other latencies until images "
        "rule them out. Set it to false where one clock stamps images and telemetry: latency_s is "
        "taken for exact then, unless noise.latency_s is above 0.",
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
        (),
        "Class names that are robots; others are refused as wrong_class. Empty: all.",
        dynamic=True,
    )
    area: str = key(
        "",
        "Area of operation: a GeoJSON file with polygons (holes count), or its text. Boxes outside "
        "by more than their uncertainty are refused as outside_area. Empty: everywhere.",
        dynamic=True,
    )


@dataclass(frozen=True)
class TracksConfig:
    """Tracking: from single positions to labelled robots."""

    gate_probability: float = key(
        0.997, "Probability that a robot's measurement lies in its gate.", low=0.5, high=0.999999
    )
    confirm_hits: int = key(
        3, "Measurements that confirm a track; more is slower and safer.", low=1, high=100
    )
    confirm_window_s: float = key(
        2.0,
        "Time within which these measurements must occur. If images are too rare for that, but at "
        "least every 3.5 s with the defaults, it is extended and one more is required.",
        unit="s",
        low=0.05,
        high=60.0,
    )
    confirm_score: float = key(
        0.0,
        "Least mean score of a robot's boxes: a track is confirmed only when the mean of their log "
        "odds exceeds this by its own uncertainty. Swimmers and boats last as robots do, but score "
        "lower in the mean. A robot that scores lower is never confirmed, so it depends on the "
        "detector: for the shipped one, over water with other things, 0.7. 0: any.",
        low=0.0,
        high=1.0,
        dynamic=True,
    )
    coast_s: float = key(
        120.0,
        "A confirmed robot that is not detected is predicted for this long, with growing "
        "covariance, before its track is lost.",
        unit="s",
        low=0.0,
        high=3600.0,
    )
    max_speed: float = key(
        1.5,
        "Greatest speed over ground of a robot. Boxes that imply more, by 3 sigma or half of it, "
        "are refused as too_fast, and no label is given again farther away after a restart. Half "
        "of it is one sigma of an unknown velocity: of a new track, out of view, of an unnoticed "
        "manoeuvre, in re-identification and in the estimation of latency; a quarter that of a "
        "manoeuvre in the test for a rotating camera. Too small refuses true motion, too large "
        "accepts clutter.",
        unit="m/s",
        low=0.01,
        high=50.0,
    )
    find_moored: bool = key(
        True,
        "Find out which robots stay or drift with the current, and use it: positions are several "
        "times as exact where two or more do, at twice the processor time; where all swim, nothing "
        "changes but a tenth of the time. false: all are taken to swim.",
    )


@dataclass(frozen=True)
class MapConfig:
    """The local frame, x east, y north; origin NaN: at the first consistent fixes."""

    frame: str = key(
        "",
        "Name of the frame. Empty: map, or <namespace>/map under a namespace. MAVROS publishes "
        "its own frame map with another origin: give another name beside it.",
    )
    publish_tf: bool = key(
        True, "Publish the transform from it to each robot, <namespace>/<robot>/course, on /tf."
    )
    publish_earth_tf: bool = key(
        True,
        "Publish the transform from earth (REP 105) to it on /tf_static. False where another "
        "program does, since a frame has one parent.",
    )
    latitude_deg: float = key(
        NAN, "Latitude of the origin.", unit="deg", low=-90.0, high=90.0, optional=True
    )
    longitude_deg: float = key(
        NAN, "Longitude of the origin.", unit="deg", low=-180.0, high=180.0, optional=True
    )
    altitude_m: float = key(
        NAN,
        "Ellipsoidal altitude of the origin, where z is 0. NaN: z is 0 on the water.",
        unit="m",
        low=-500.0,
        high=10000.0,
        optional=True,
    )


@dataclass(frozen=True)
class UpdatesConfig:
    """Positions for other filters, robots/<id>/position_update: independent of one another."""

    interval_s: float = key(
        NAN,
        "Least time between two of them. NaN: three times noise.correlation_time_s, so 900 s. A "
        "shorter one widens their covariance, 20 times with 30 s: for filters that average over "
        "many, such as dead reckoning with a Doppler log.",
        unit="s",
        low=30.0,
        high=86400.0,
        optional=True,
    )
    settle_s: float = key(
        5.0,
        "A robot must have been measured for so long, without as long a gap.",
        unit="s",
        low=0.0,
        high=600.0,
    )
    covariance_parts: bool = key(
        False,
        "true: with each measured position its covariance in two parts, robots/<id>/"
        "covariance_shared and covariance_white, for filters that estimate the shared errors "
        "themselves. It takes some 0.1 ms an image.",
    )
