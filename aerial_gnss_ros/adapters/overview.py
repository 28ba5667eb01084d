# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The topic `overview`: one image's result with its surroundings, as JSON for a web page.

Angles are in degrees, positions [latitude, longitude]; null stands for what is not known.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.area_of_operation import Polygon
from aerial_gnss_ros.core.telemetry.input_status import InputState, InputStatus
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import RobotEstimate
from aerial_gnss_ros.core.values.overview import Overview
from aerial_gnss_ros.core.values.reference_place import ReferencePlace
from aerial_gnss_ros.text.plain_text import printable

OVERVIEW = ("overview", "std_msgs/msg/String")
OK, WARNING, ERROR = "ok", "warning", "error"
_DEGREES = 9  # decimals: a tenth of a millimetre


@dataclass(frozen=True)
class Light:
    """The condition of one input or judgement, as a light and a sentence.

    Attributes:
        name: of the input, such as fix.
        level: ok, warning or error.
        words: its condition.
    """

    name: str
    level: str
    words: str


@dataclass(frozen=True)
class DroneInFleet:
    """One of several drones, for an overview of all.

    Attributes:
        name: of the drone.
        stamp_ns: of its newest image, ns.
        pose: of its camera then.
        footprint: (n, 2) as in `Overview`.
        sees: the fleet's names of the robots in that image.
    """

    name: str
    stamp_ns: int
    pose: CameraPose
    footprint: NDArray[np.float64]
    sees: tuple[str, ...]


def overview_text(
    overview: Overview,
    now_ns: int,
    area: Sequence[Polygon],
    lights: Sequence[Light] = (),
    drones: Sequence[DroneInFleet] = (),
) -> str:
    """Return the JSON text of an overview.

    Args:
        overview: of one image.
        now_ns: the clock by which ages count, ns.
        area: the area of operation, rings of longitude and latitude in degrees.
        lights: of the inputs.
        drones: of a fleet, whose overview has no drone and footprint of its own.
    """
    result = overview.result
    fields = {
        "stamp_ns": result.stamp_ns,
        "now_ns": now_ns,
        "drone": None if result.pose is None else _drone(result.pose),
        "footprint": _outline(overview.footprint),
        "image_size": overview.image_size,
        "robots": [
            _robot(one, pixel, depth)
            for one, pixel, depth in zip(
                result.estimates, overview.pixels.tolist(), overview.depths.tolist(), strict=True
            )
        ],
        "references": [_reference(one) for one in overview.references],
        "area": [[ring[:, ::-1].tolist() for ring in polygon] for polygon in area],
        "lights": [vars(light) for light in lights],
    }
    if drones:
        fields["drones"] = [_drone_in_fleet(one) for one in drones]
    return json.dumps(fields, allow_nan=False, separators=(",", ":"))


def input_lights(inputs: Mapping[str, InputStatus], complaints: Sequence[str] = ()) -> list[Light]:
    """Return a light for each input that is used, and one for what is wrong with the positions.

    Args:
        inputs: as the estimator judges them.
        complaints: its sentences about boxes and noise; empty where all is well.
    """
    lights = [
        _input_light(status)
        for status in inputs.values()
        if status.state not in (InputState.UNUSED, InputState.CONSTANT)
    ]
    words = " ".join(one for one in complaints if one)
    return [*lights, Light("positions", WARNING if words else OK, words or "consistent")]


def _input_light(status: InputStatus) -> Light:
    if status.state is InputState.BAD:
        last = f"the last message was unusable ({status.bad} of {status.count})"
        return Light(status.name, ERROR, f"{last}: {printable(status.trouble)}")
    if status.state is InputState.STALE:
        return Light(status.name, WARNING, "its stamps lag behind the images")
    if status.state is InputState.WAITING:
        return Light(status.name, ERROR, "never received")
    return Light(status.name, OK, "received")


def _drone(pose: CameraPose) -> dict[str, Any]:
    """Return the camera's position and where it looks; no heading where it looks straight down."""
    east, north, up = pose.enu_from_camera[:, 0].tolist()
    level = math.hypot(east, north)
    heading = math.degrees(math.atan2(east, north)) % 360.0 if level > 0.02 else math.nan
    return {
        "place": _place(pose.latitude, pose.longitude),
        "height_m": _number(pose.height, 2),
        "camera_heading_deg": _number(heading, 1),
        "camera_below_horizon_deg": _number(math.degrees(math.atan2(-up, level)), 1),
    }


def _drone_in_fleet(one: DroneInFleet) -> dict[str, Any]:
    return {
        "name": one.name,
        "stamp_ns": one.stamp_ns,
        **_drone(one.pose),
        "footprint": _outline(one.footprint),
        "sees": list(one.sees),
    }


def _outline(footprint: NDArray[np.float64]) -> list[list[float]]:
    return [_place(*row) for row in footprint.tolist()]


def _robot(one: RobotEstimate, pixel: list[float], depth: float) -> dict[str, Any]:
    (east, cross), (_, north) = one.covariance[:2, :2].tolist()
    return {
        "id": one.robot_id,
        "class": printable(one.class_id),
        "state": str(one.state),
        "place": _place(one.latitude, one.longitude),
        "covariance_m2": [_number(value, 6) for value in (east, cross, north)],
        "velocity_mps": [_number(value, 3) for value in one.velocity.tolist()],
        "last_seen_ns": one.last_seen_ns,
        "depth_m": _number(depth, 2),
        "pixel": None if math.isnan(pixel[0]) else [round(value, 1) for value in pixel],
    }


def _reference(one: ReferencePlace) -> dict[str, Any]:
    sigma = math.sqrt(max(float(np.linalg.eigvalsh(one.covariance)[-1]), 0.0))
    place = _place(one.latitude, one.longitude)
    return {"name": one.name, "place": place, "sigma_m": _number(sigma, 3)}


def _place(latitude: float, longitude: float) -> list[float]:
    """Return latitude and longitude (rad) in degrees."""
    return [round(math.degrees(latitude), _DEGREES), round(math.degrees(longitude), _DEGREES)]


def _number(value: float, decimals: int) -> float | None:
    return round(value, decimals) if math.isfinite(value) else None
