# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transforms for /tf and /tf_static: each robot's frame in `map`, and `map` on Earth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.map_frame import EARTH, Frames
from aerial_gnss_ros.adapters.results import OutgoingMessage, course, yaw_quaternion
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.core.geometry.frames import quaternion_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import ecef_of_place, enu_axes
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, State

TF, TF_STATIC = "/tf", "/tf_static"
TF_TYPE = "tf2_msgs/msg/TFMessage"


def course_transforms(result: FrameResult, frames: Frames) -> OutgoingMessage | None:
    """Return `map` to each robot's course frame, None without a robot.

    A transform has no covariance: a coasting robot's frame is at its predicted position.
    """
    found = []
    for estimate in result.estimates:
        if estimate.state is State.LOST or not np.all(np.isfinite(estimate.position)):
            continue
        yaw, _ = course(estimate) or (0.0, math.nan)  # unknown: the axes of map
        east, north = estimate.position
        place = (float(east), float(north), frames.up(estimate, result.datum)[0])
        found.append(
            _transform(
                estimate.stamp_ns,
                frames.map,
                frames.course(estimate.robot_id),
                place,
                yaw_quaternion(yaw),
            )
        )
    return OutgoingMessage(TF, TF_TYPE, {"transforms": found}) if found else None


def earth_transform(stamp_ns: int, datum: MapDatum, frames: Frames) -> OutgoingMessage:
    """Return `earth` to `map`, which does not change.

    A transform cannot express an unknown altitude: it then uses that of mean sea level (EGM96),
    while `map_datum` has NaN.
    """
    altitude = datum.altitude
    if math.isnan(altitude):
        altitude = undulation(datum.latitude, datum.longitude)
    place = ecef_of_place(datum.latitude, datum.longitude, altitude)
    x, y, z, w = quaternion_from_matrix(enu_axes(datum.latitude, datum.longitude).T).tolist()
    rotation = {"x": x, "y": y, "z": z, "w": w}
    transform = _transform(stamp_ns, EARTH, frames.map, tuple(place.tolist()), rotation)
    return OutgoingMessage(TF_STATIC, TF_TYPE, {"transforms": [transform]})


def _transform(
    stamp_ns: int, parent: str, child: str, place: tuple[float, ...], rotation: dict[str, float]
) -> dict[str, Any]:
    return {
        "header": header_fields(stamp_ns, parent),
        "child_frame_id": child,
        "transform": {
            "translation": dict(zip("xyz", place, strict=True)),
            "rotation": rotation,
        },
    }
