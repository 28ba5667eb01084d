# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results as nested dicts in ROS field names; `bags` and `nodes` convert them to messages.

A dict contains only fields that are not zero, empty or identity. Positions are east, north, up in
the map frame; only GeoPoseWithCovarianceStamped has north first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from aerial_gnss_ros.adapters.map_frame import ALTITUDE_M2, UNKNOWN_LENGTH_M2, Frames
from aerial_gnss_ros.adapters.markers import marker_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.core.numerics.small_arrays import all_finite
from aerial_gnss_ros.core.values.estimates import (
    Current,
    FrameResult,
    MapDatum,
    RobotEstimate,
    State,
)
from aerial_gnss_ros.core.values.samples import Array

ROOT = Frames()
"""Frames of an estimator in the root namespace."""

UNKNOWN_ANGLE_RAD2 = math.pi**2
"""Variance of an unknown angle: one sigma is half a turn."""

COURSE_KNOWN = 9.21
"""Squared ratio of velocity to its uncertainty above which the course is published: 99 % of a
resting robot's estimates are below (chi-square, two degrees of freedom)."""

FIX, NO_FIX = 0, -1  # sensor_msgs/NavSatStatus
SERVICE_GPS = 1
COVARIANCE_APPROXIMATED = 1  # sensor_msgs/NavSatFix


class Boxes(Protocol):
    """Attributes used of `detection.base.Detections`, which is above this package."""

    @property
    def xywh(self) -> Array:
        """(n, 4) centre and size, px."""

    @property
    def scores(self) -> Array:
        """(n,) 0 to 1."""

    @property
    def names(self) -> tuple[str, ...]:
        """The class name of each box."""


@dataclass(frozen=True)
class OutgoingMessage:
    """One message to publish or record.

    Attributes:
        topic: relative name.
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        fields: nested dict in ROS field names; numbers, text, lists, dicts.
    """

    topic: str
    msgtype: str
    fields: dict[str, Any]


CURRENT = "current"
MAP_DATUM = "map_datum"
POSITION_UPDATE = "position_update"
COVARIANCE_SHARED, COVARIANCE_WHITE = "covariance_shared", "covariance_white"
MARKERS = ("robots/markers", "visualization_msgs/msg/MarkerArray")


def result_messages(result: FrameResult, frames: Frames = ROOT) -> list[OutgoingMessage]:
    """Return all messages of an estimator for one image except transforms, in a fixed order."""
    return [*position_messages(result, frames), markers(result, frames)]


def markers(result: FrameResult, frames: Frames = ROOT) -> OutgoingMessage:
    """Return the markers of all robots."""
    return OutgoingMessage(*MARKERS, marker_array(result, frames))


def position_messages(result: FrameResult, frames: Frames = ROOT) -> list[OutgoingMessage]:
    """Return the datum, the current and each robot's position, in a fixed order."""
    messages = []
    if result.datum is not None:
        messages.append(map_datum(result.stamp_ns, result.datum, frames))
    if result.current is not None:
        messages.append(current(result.stamp_ns, result.current, frames))
    for estimate in result.estimates:
        base = f"robots/{estimate.robot_id}"
        messages += [
            OutgoingMessage(
                f"{base}/geo_pose",
                "geographic_msgs/msg/GeoPoseWithCovarianceStamped",
                geo_pose(estimate, frames),
            ),
            OutgoingMessage(
                f"{base}/fix", "sensor_msgs/msg/NavSatFix", nav_sat_fix(estimate, frames)
            ),
            OutgoingMessage(
                f"{base}/odom", "nav_msgs/msg/Odometry", odometry(estimate, result.datum, frames)
            ),
        ]
    return messages


def course(estimate: RobotEstimate) -> tuple[float, float] | None:
    """Return a robot's course as ENU yaw in rad and its variance in rad², None if unknown.

    The course is known if the velocity exceeds its uncertainty (`COURSE_KNOWN`); its variance is
    that of atan2 to first order.
    """
    velocity, covariance = estimate.velocity, estimate.covariance[2:, 2:]
    if not (all_finite(velocity) and all_finite(covariance)):
        return None
    speed2 = float(velocity @ velocity)
    if speed2 == 0.0 or _squared_ratio(velocity, covariance) < COURSE_KNOWN:
        return None
    across = np.array([-velocity[1], velocity[0]]) / speed2
    return math.atan2(velocity[1], velocity[0]), float(across @ covariance @ across)


def _squared_ratio(velocity: Array, covariance: Array) -> float:
    """Return the squared ratio of a velocity (2,) to its uncertainty, covariance (2, 2)."""
    (x, y), ((a, b), (_, d)) = velocity.tolist(), covariance.tolist()
    determinant = a * d - b * b
    if determinant > 1e-9 * (a + d) ** 2:
        return float((d * x * x - 2.0 * b * x * y + a * y * y) / determinant)
    return float(
        velocity @ np.linalg.pinv(covariance) @ velocity
    )  # singular: known in one direction only


def map_datum(stamp_ns: int, datum: MapDatum, frames: Frames = ROOT) -> OutgoingMessage:
    """Return the origin of the map frame as a geographic_msgs/GeoPoseStamped."""
    fields = {
        "header": header_fields(stamp_ns, frames.map),
        "pose": {
            "position": _geo_point(datum.latitude, datum.longitude, datum.altitude),
            "orientation": yaw_quaternion(0.0),
        },
    }
    return OutgoingMessage(MAP_DATUM, "geographic_msgs/msg/GeoPoseStamped", fields)


def current(stamp_ns: int, known: Current, frames: Frames = ROOT) -> OutgoingMessage:
    """Return a geometry_msgs/TwistWithCovarianceStamped, East, North, Up; no more is known."""
    east, north = known.velocity.tolist()
    covariance = np.diag(3 * [UNKNOWN_LENGTH_M2] + 3 * [UNKNOWN_ANGLE_RAD2])
    covariance[:2, :2] = known.covariance
    fields = {
        "header": header_fields(stamp_ns, frames.map),
        "twist": {
            "twist": {"linear": {"x": east, "y": north}},
            "covariance": _floats(covariance),
        },
    }
    return OutgoingMessage(CURRENT, "geometry_msgs/msg/TwistWithCovarianceStamped", fields)


def geo_pose(estimate: RobotEstimate, frames: Frames = ROOT) -> dict[str, Any]:
    """Return a geographic_msgs/GeoPoseWithCovarianceStamped; covariance north, east, up."""
    heading = course(estimate)
    yaw, yaw_variance = heading or (0.0, UNKNOWN_ANGLE_RAD2)
    east_north_up = _position_covariance(estimate)
    north_east_up = east_north_up[[1, 0, 2]][:, [1, 0, 2]]
    return {
        "header": header_fields(estimate.stamp_ns, frames.map),
        "pose": {
            "pose": {
                "position": _geo_point(estimate.latitude, estimate.longitude, estimate.altitude),
                "orientation": yaw_quaternion(yaw),
            },
            "covariance": _pose_covariance(north_east_up, yaw_variance),
        },
    }


def nav_sat_fix(estimate: RobotEstimate, frames: Frames = ROOT) -> dict[str, Any]:
    """Return a sensor_msgs/NavSatFix; covariance east, north, up; no fix while coasting."""
    measured = estimate.state is State.CONFIRMED
    return {
        "header": header_fields(estimate.stamp_ns, frames.course(estimate.robot_id)),
        "status": {"status": FIX if measured else NO_FIX, "service": SERVICE_GPS},
        **_geo_point(estimate.latitude, estimate.longitude, estimate.altitude),
        "position_covariance": _floats(_position_covariance(estimate)),
        "position_covariance_type": COVARIANCE_APPROXIMATED,
    }


def odometry(
    estimate: RobotEstimate, datum: MapDatum | None, frames: Frames = ROOT
) -> dict[str, Any]:
    """Return a nav_msgs/Odometry in the map frame, twist along the course if known."""
    heading = course(estimate)
    yaw, yaw_variance = heading or (0.0, UNKNOWN_ANGLE_RAD2)
    covariance = _position_covariance(estimate)
    up, covariance[2, 2] = frames.up(estimate, datum)
    course_from_enu = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    velocity, velocity_covariance = _known_velocity(estimate)
    along, left = course_from_enu @ velocity
    twist_covariance = np.diag([0.0, 0.0, UNKNOWN_LENGTH_M2] + 3 * [UNKNOWN_ANGLE_RAD2])
    twist_covariance[:2, :2] = course_from_enu @ velocity_covariance @ course_from_enu.T
    east, north = estimate.position
    return {
        "header": header_fields(estimate.stamp_ns, frames.map),
        "child_frame_id": frames.course(estimate.robot_id),
        "pose": {
            "pose": {
                "position": {"x": float(east), "y": float(north), "z": up},
                "orientation": yaw_quaternion(yaw),
            },
            "covariance": _pose_covariance(covariance, yaw_variance),
        },
        "twist": {
            "twist": {"linear": {"x": float(along), "y": float(left)}},
            "covariance": _floats(twist_covariance),
        },
    }


def position_update(
    estimate: RobotEstimate, datum: MapDatum | None, frames: Frames = ROOT
) -> OutgoingMessage:
    """Return a sample for other filters, a geometry_msgs/PoseWithCovarianceStamped.

    Only the position is stated; orientation has the variance of what is not known.
    """
    return _position(POSITION_UPDATE, estimate, datum, frames)


def covariance_parts(
    estimate: RobotEstimate, datum: MapDatum | None, frames: Frames = ROOT
) -> tuple[OutgoingMessage, ...]:
    """Return the position twice, with the shared and with the white part of its covariance.

    East and North of both add up to the published covariance; the variance of the height is in
    both. Nothing of a predicted position, or where `RobotEstimate.white` is absent.
    """
    if estimate.white is None or estimate.state is not State.CONFIRMED:
        return ()
    plane = estimate.covariance[:2, :2]
    parts = {COVARIANCE_SHARED: plane - estimate.white, COVARIANCE_WHITE: estimate.white}
    return tuple(_position(name, estimate, datum, frames, part) for name, part in parts.items())


def _position(
    name: str,
    estimate: RobotEstimate,
    datum: MapDatum | None,
    frames: Frames,
    plane: Array | None = None,
) -> OutgoingMessage:
    """Return a position alone, with its covariance or another one (2, 2) East and North."""
    covariance = _position_covariance(estimate)
    up, covariance[2, 2] = frames.up(estimate, datum)
    if plane is not None:
        covariance[:2, :2] = plane
    east, north = estimate.position
    fields = {
        "header": header_fields(estimate.stamp_ns, frames.map),
        "pose": {
            "pose": {
                "position": {"x": float(east), "y": float(north), "z": up},
                "orientation": yaw_quaternion(0.0),
            },
            "covariance": _pose_covariance(covariance, UNKNOWN_ANGLE_RAD2),
        },
    }
    return OutgoingMessage(
        f"robots/{estimate.robot_id}/{name}",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        fields,
    )


def detection_array(detections: Boxes, header: dict[str, Any]) -> dict[str, Any]:
    """Return a vision_msgs/Detection2DArray.

    Args:
        detections: boxes in pixels of the source image.
        header: the image's header as fields, copied to the array and to each box.
    """
    found = []
    for (x, y, width, height), score, name in zip(
        detections.xywh, detections.scores, detections.names, strict=True
    ):
        found.append(
            {
                "header": header,
                "results": [{"hypothesis": {"class_id": name, "score": float(score)}}],
                "bbox": {
                    "center": {"position": {"x": float(x), "y": float(y)}},
                    "size_x": float(width),
                    "size_y": float(height),
                },
            }
        )
    return {"header": header, "detections": found}


def _known_velocity(estimate: RobotEstimate) -> tuple[Array, Array]:
    """Return velocity and covariance, ENU; zero with a huge variance if not estimated."""
    velocity, covariance = estimate.velocity, estimate.covariance[2:, 2:]
    if all_finite(velocity) and all_finite(covariance):
        return velocity, covariance
    return np.zeros(2), np.diag([UNKNOWN_LENGTH_M2, UNKNOWN_LENGTH_M2])


def _position_covariance(estimate: RobotEstimate) -> Array:
    """Return (3, 3) east, north, up, m²."""
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = estimate.covariance[:2, :2]
    covariance[2, 2] = UNKNOWN_LENGTH_M2 if math.isnan(estimate.altitude) else ALTITUDE_M2
    return covariance


def _pose_covariance(position: Array, yaw_variance: float) -> list[float]:
    """Return 36 numbers; a robot's roll and pitch are unknown, its yaw is its course."""
    covariance = np.diag([0.0, 0.0, 0.0, UNKNOWN_ANGLE_RAD2, UNKNOWN_ANGLE_RAD2, yaw_variance])
    covariance[:3, :3] = position
    return _floats(covariance)


def _geo_point(latitude: float, longitude: float, altitude: float) -> dict[str, float]:
    return {
        "latitude": math.degrees(latitude),
        "longitude": math.degrees(longitude),
        "altitude": float(altitude),
    }


def yaw_quaternion(yaw: float) -> dict[str, float]:
    """Return a rotation by `yaw`, rad, about the vertical."""
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2.0), "w": math.cos(yaw / 2.0)}


def _floats(matrix: Array) -> list[float]:
    floats: list[float] = matrix.ravel().tolist()
    return floats
