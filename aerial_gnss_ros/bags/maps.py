# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes tracks as GeoJSON (QGIS, web, Foxglove), GPX (chart plotters) and KML (Google Earth)."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from itertools import pairwise
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from aerial_gnss_ros.core.values.estimates import RobotEstimate
from aerial_gnss_ros.text.plain_text import printable

Tracks = Mapping[str, Sequence[RobotEstimate]]

_DECIMALS = 10
# KML's order is alpha, blue, green, red; colours that differ for colour-blind eyes (Okabe, Ito).
_COLORS = ("ffb27200", "ff005ed5", "ff739e00", "ffa779cc", "ff009fe6", "ffe9b456")


def geojson(tracks: Tracks) -> str:
    """Return a FeatureCollection (RFC 7946): each robot's line with its stamps, and last position.

    QGIS and web maps open it directly; Foxglove's map panel reads `name` and `style`. A line that
    crosses the antimeridian is cut there, as the RFC asks (3.1.9).
    """
    features = []
    for index, (robot_id, track) in enumerate(tracks.items()):
        last = track[-1]
        color = "#" + "".join(_COLORS[index % len(_COLORS)][i : i + 2] for i in (6, 4, 2))
        common = {
            "name": robot_id,
            "robot_id": robot_id,
            "class_id": printable(last.class_id),
            "style": {"color": color, "weight": 3},
        }
        if len(track) > 1:  # a GeoJSON line has at least two positions
            times = {
                "stamps_ns": [e.stamp_ns for e in track],
                "states": [str(e.state) for e in track],
            }
            line = _line([_coordinates(e) for e in track])
            features.append({"type": "Feature", "properties": common | times, "geometry": line})
        point = {"type": "Point", "coordinates": _coordinates(last)}
        details = {
            "stamp_ns": last.stamp_ns,
            "time": iso_time(last.stamp_ns),
            "state": str(last.state),
            "sigma_m": round(_sigma(last), 4),
        }
        features.append({"type": "Feature", "properties": common | details, "geometry": point})
    return (
        json.dumps({"type": "FeatureCollection", "features": features}, indent=1, allow_nan=False)
        + "\n"
    )


def gpx(tracks: Tracks) -> str:
    """Return GPX 1.1: a track for each robot, and a waypoint at its last position.

    It has no elevations: programs take them as above sea level, which is not measured here.
    """
    marks = "".join(
        f"<wpt {_gpx_place(track[-1])}><time>{iso_time(track[-1].stamp_ns)}</time>"
        f"<name>{_xml(robot_id)}</name>"
        f"<desc>{_xml(_words(track[-1]))}</desc></wpt>\n"
        for robot_id, track in tracks.items()
    )
    lines = "".join(
        f"<trk><name>{_xml(robot_id)}</name><type>{_xml(track[-1].class_id)}</type><trkseg>\n"
        + "".join(
            f"<trkpt {_gpx_place(e)}><time>{iso_time(e.stamp_ns)}</time></trkpt>\n" for e in track
        )
        + "</trkseg></trk>\n"
        for robot_id, track in tracks.items()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<gpx version="1.1" creator="aerial_gnss_ros" xmlns="http://www.topografix.com/GPX/1/1">\n'
        f"{marks}{lines}</gpx>\n"
    )


def kml(tracks: Tracks) -> str:
    """Return a KML document with a moving mark and a line for each robot."""
    parts = [_robot_kml(i, robot_id, track) for i, (robot_id, track) in enumerate(tracks.items())]
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<kml xmlns="http://www.opengis.net/kml/2.2" '
        'xmlns:gx="http://www.google.com/kml/ext/2.2">\n'
        "<Document>\n<name>Robot positions</name>\n"
        f"{''.join(parts)}</Document>\n</kml>\n"
    )


def iso_time(stamp_ns: int) -> str:
    """Return a stamp as UTC in ISO 8601 with milliseconds."""
    seconds, rest = divmod(stamp_ns, 1_000_000_000)
    date = datetime.fromtimestamp(seconds, tz=timezone.utc)
    return f"{date:%Y-%m-%dT%H:%M:%S}.{rest // 1_000_000:03d}Z"


def _robot_kml(index: int, robot_id: str, track: Sequence[RobotEstimate]) -> str:
    last, color = track[-1], _COLORS[index % len(_COLORS)]
    whens = "".join(f"<when>{iso_time(e.stamp_ns)}</when>\n" for e in track)
    coords = "".join(f"<gx:coord>{_spaced(e, ' ')}</gx:coord>\n" for e in track)
    sentence = _words(last)
    return (
        f"<Placemark>\n<name>{_xml(robot_id)}</name>\n"
        f"<description>{_xml(sentence)}</description>\n"
        f"<Style><IconStyle><color>{color}</color></IconStyle>"  # the schema's order
        f"<LineStyle><color>{color}</color><width>3</width></LineStyle></Style>\n"
        "<gx:Track>\n<altitudeMode>clampToGround</altitudeMode>\n"
        f"{whens}{coords}</gx:Track>\n</Placemark>\n"
    )


def _xml(text: str) -> str:
    return escape(printable(text))


def _words(last: RobotEstimate) -> str:
    return (
        f"{last.class_id}, last position {iso_time(last.stamp_ns)}, {last.state}, "
        f"one sigma {_sigma(last):.2f} m"
    )


def _gpx_place(estimate: RobotEstimate) -> str:
    longitude, latitude = _coordinates(estimate)[:2]
    longitude = -180.0 if longitude >= 180.0 else longitude  # GPX's end before 180
    return f'lat="{latitude:.10f}" lon="{longitude:.10f}"'


def _line(coordinates: list[list[float]]) -> dict[str, Any]:
    """Return a LineString, or a MultiLineString cut at the antimeridian."""
    parts = [[coordinates[0]]]
    for before, after in pairwise(coordinates):
        if abs(after[0] - before[0]) > 180.0:
            side = math.copysign(180.0, before[0])
            width = after[0] + 2.0 * side - before[0]
            share = (side - before[0]) / width if width else 0.0  # both are on it
            latitude = round(before[1] + share * (after[1] - before[1]), _DECIMALS)
            height = before[2:]
            parts[-1].append([side, latitude, *height])
            parts.append([[-side, latitude, *height]])
        parts[-1].append(after)
    if len(parts) == 1:
        return {"type": "LineString", "coordinates": parts[0]}
    return {"type": "MultiLineString", "coordinates": parts}


def _spaced(estimate: RobotEstimate, separator: str) -> str:
    longitude, latitude = _coordinates(estimate)[:2]
    return separator.join([f"{longitude:.10f}", f"{latitude:.10f}", "0"])


def _coordinates(estimate: RobotEstimate) -> list[float]:
    """Return longitude, latitude and, if known, altitude."""
    place = [
        round(math.degrees(estimate.longitude), _DECIMALS),
        round(math.degrees(estimate.latitude), _DECIMALS),
    ]
    if math.isfinite(estimate.altitude):
        place.append(round(estimate.altitude, 4))
    return place


def _sigma(estimate: RobotEstimate) -> float:
    return math.sqrt(float(np.trace(estimate.covariance[:2, :2])) / 2.0)
