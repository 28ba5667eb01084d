# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A published position for other programs: Cursor on Target XML, MAVLink fields."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any
from xml.sax.saxutils import quoteattr

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.plain_text import printable

COT_UNKNOWN = 9_999_999.0
"""Cursor on Target's value of an unknown height or error."""

_SECOND_NS = 1_000_000_000


@dataclass(frozen=True)
class Sighting:
    """One robot's position as it was published.

    Attributes:
        robot_id: such as `aqua_1`.
        stamp_ns: of the image, ns.
        latitude: rad, WGS84.
        longitude: rad.
        altitude: of the water above the ellipsoid, m; NaN when unknown.
        sigma: one sigma per horizontal axis, m.
        measured: False if the robot is coasting.
        namespace: of the drone's estimator without slashes at its ends, such as `drone1`; empty
            with one drone.
    """

    robot_id: str
    stamp_ns: int
    latitude: float
    longitude: float
    altitude: float
    sigma: float
    measured: bool
    namespace: str = ""


def sighting(robot_id: str, msg: Any, namespace: str = "") -> Sighting:
    """Return the position in a `robots/<id>/fix` (sensor_msgs/NavSatFix).

    Raises:
        InputError: its position is not on Earth.
    """
    if not (abs(msg.latitude) <= 90.0 and abs(msg.longitude) <= 180.0):
        raise InputError(
            f"the position of {robot_id}, {msg.latitude:g}, {msg.longitude:g}, is invalid"
        )
    east, north = float(msg.position_covariance[0]), float(msg.position_covariance[4])
    return Sighting(
        robot_id,
        nanoseconds(msg.header.stamp),
        math.radians(msg.latitude),
        math.radians(msg.longitude),
        float(msg.altitude),
        math.sqrt(max(0.0, 0.5 * (east + north))),
        int(msg.status.status) >= 0,
        namespace.strip("/"),
    )


def cursor_on_target(seen: Sighting, kind: str = "a-f-S", stale_s: float = 30.0) -> bytes:
    """Return a Cursor on Target event (version 2.0) for TAK programs by UDP.

    Args:
        seen: the position; its stamp is the event's time, so that an old one shows as stale.
        kind: the event's type: a-f-S is a friendly sea surface track, a-f-U a subsurface one.
        stale_s: time after which receivers show the position as outdated, s.
    """
    known = math.isfinite(seen.altitude)
    # Robots of two drones may have the same name; receivers distinguish marks by uid alone.
    drone = [seen.namespace] if seen.namespace else []
    place = {
        "lat": f"{math.degrees(seen.latitude):.8f}",
        "lon": f"{math.degrees(seen.longitude):.8f}",
        "hae": f"{seen.altitude if known else COT_UNKNOWN:.2f}",
        # One sigma, as the schema defines error.
        "ce": f"{seen.sigma if math.isfinite(seen.sigma) else COT_UNKNOWN:.2f}",
        "le": f"{COT_UNKNOWN:.1f}",
    }
    time = _iso(seen.stamp_ns)
    event = {
        "version": "2.0",
        "uid": ".".join(["aerial_gnss_ros", *drone, seen.robot_id]),
        "type": kind,
        "how": "m-f",  # machine-generated, fused
        "time": time,
        "start": time,
        "stale": _iso(seen.stamp_ns + round(stale_s * 1e9)),
    }
    name = "/".join([*drone, seen.robot_id])
    state = "seen in the image" if seen.measured else "out of view, predicted"
    return (
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>'
        f"<event {_attributes(event)}><point {_attributes(place)}/><detail>"
        f"<contact callsign={quoteattr(printable(name))}/><remarks>{state}</remarks>"
        "</detail></event>"
    ).encode()


def tracking_geo_status(seen: Sighting) -> dict[str, Any]:
    """Return the fields of a MAVLink CAMERA_TRACKING_GEO_STATUS (276).

    Its altitude is above mean sea level: the ellipsoidal one less EGM96's undulation, NaN if
    unknown, as are velocity, distance and heading, which this message cannot omit.
    """
    altitude = seen.altitude
    if math.isfinite(altitude):
        altitude -= undulation(seen.latitude, seen.longitude)
    unknown = ("v_acc", "vel_n", "vel_e", "vel_d", "vel_acc", "dist", "hdg", "hdg_acc")
    return {
        "tracking_status": 1 if seen.measured else 0,  # active, idle
        "lat": round(math.degrees(seen.latitude) * 1e7),
        "lon": round(math.degrees(seen.longitude) * 1e7),
        "alt": altitude,
        "h_acc": seen.sigma,
        **dict.fromkeys(unknown, math.nan),
    }


def host_and_port(text: str) -> tuple[str, int]:
    """Parse HOST:PORT; an IPv6 address stands in brackets.

    Raises:
        InputError: it has another form.
    """
    host, _, port = text.rpartition(":")
    host = host.strip("[]")
    if not host or not port.isdecimal() or not 1 <= int(port) <= 65535:
        raise InputError(f"{text!r} is not HOST:PORT, such as 127.0.0.1:4242.")
    return host, int(port)


def _attributes(values: dict[str, str]) -> str:
    return " ".join(f"{name}={quoteattr(printable(value))}" for name, value in values.items())


def _iso(stamp_ns: int) -> str:
    seconds, rest = divmod(stamp_ns, _SECOND_NS)
    date = datetime.fromtimestamp(seconds, tz=timezone.utc)
    return f"{date:%Y-%m-%dT%H:%M:%S}.{rest // 1_000_000:03d}Z"
