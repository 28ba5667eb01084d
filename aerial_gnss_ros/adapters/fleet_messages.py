# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages between drones and fleet besides `sightings`: parameters, and what is wanted again.

JSON in a String, as `sighting_messages` says why.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.adapters.sighting_messages import (
    VERSION,
    drone_name,
    message_document,
    whole,
)
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.core.values.estimates import MapDatum

PARAMETERS = ("sightings/parameters", "std_msgs/msg/String")
REQUEST = ("sightings/request", "std_msgs/msg/String")
_OWN_FILES = ("state_file", "detections.area")  # of that drone's computer


@dataclass(frozen=True)
class DroneParameters:
    """What the fleet has to know of a drone beside its sightings.

    Attributes:
        drone: its name.
        config: parameters of its estimator.
        datum: origin of its frame `map`; None before its first fix.
    """

    drone: str
    config: EstimatorConfig
    datum: MapDatum | None


@dataclass(frozen=True)
class Request:
    """Sightings that the fleet wants again.

    Attributes:
        drone: name of the drone.
        session: of the drone's estimator.
        ranges: first and last sequence number of each gap.
    """

    drone: str
    session: int
    ranges: tuple[tuple[int, int], ...]


def parameters_text(drone: str, values: Mapping[str, Any], datum: MapDatum | None) -> str:
    """Return a drone's parameters as JSON.

    Args:
        drone: its name.
        values: of its estimator, by dotted name; defaults may be absent.
        datum: origin of its frame `map`, if known.
    """
    document = {
        "version": VERSION,
        "drone": drone,
        "parameters": {
            name: _plain(value)
            for name, value in values.items()
            if name not in _OWN_FILES and not (isinstance(value, float) and math.isnan(value))
        },
        "datum": None
        if datum is None
        else {
            "latitude": datum.latitude,
            "longitude": datum.longitude,
            "altitude": None if math.isnan(datum.altitude) else datum.altitude,
        },
    }
    return json.dumps(document, separators=(",", ":"))


def drone_parameters(text: str) -> DroneParameters:
    """Return a drone's parameters from JSON.

    Raises:
        InputError: it is something else, or the parameters cannot be used.
    """
    document = message_document(text, "a drone's parameters")
    drone, values = drone_name(document), document.get("parameters")
    if not isinstance(values, dict):
        raise InputError(f"drone {drone} sends no parameters.")
    try:
        config = estimator_config(values)
    except ConfigError as error:
        raise InputError(f"the parameters of drone {drone} cannot be used: {error}") from error
    return DroneParameters(drone, config, _datum(document.get("datum"), drone))


def request_text(request: Request) -> str:
    """Return a request as JSON."""
    document = {
        "version": VERSION,
        "drone": request.drone,
        "session": request.session,
        "ranges": request.ranges,
    }
    return json.dumps(document, separators=(",", ":"))


def request(text: str) -> Request:
    """Return a request from JSON.

    Raises:
        InputError: it is something else.
    """
    document = message_document(text, "a request")
    ranges = document.get("ranges")
    if not isinstance(ranges, list) or not all(
        isinstance(one, list) and len(one) == 2 and all(type(n) is int and n >= 0 for n in one)
        for one in ranges
    ):
        raise InputError("a request has no ranges of sequence numbers.")
    pairs = tuple((first, last) for first, last in ranges)
    return Request(drone_name(document), whole(document, "session"), pairs)


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _datum(value: Any, drone: str) -> MapDatum | None:
    if value is None:
        return None
    try:
        latitude, longitude = float(value["latitude"]), float(value["longitude"])
        altitude = math.nan if value["altitude"] is None else float(value["altitude"])
        fits = abs(latitude) <= math.pi / 2.0 and abs(longitude) <= math.pi
    except (KeyError, TypeError, ValueError, OverflowError):
        fits = False
    if not fits or math.isinf(altitude):
        raise InputError(f"the origin of map of drone {drone} cannot be {value!r:.80}.")
    return MapDatum(latitude, longitude, altitude)
