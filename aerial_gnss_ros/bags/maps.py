# SPDX-License-Identifier: Apache-2.0
"""Tracks for map programs: GeoJSON (QGIS, web maps) and KML (Google Earth)."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from xml.sax.saxutils import escape

import numpy as np

from aerial_gnss_ros.core.values import RobotEstimate

Tracks = Mapping[str, Sequence[RobotEstimate]]

_DECIMALS = 10
# KML's order is alpha, blue, green, red; colours that differ for colour-blind eyes (Okabe, Ito).
_COLORS = ("ffb27200", "ff005ed5", "ff739e00", "ffa779cc", "ff009fe6", "ffe9b456")


def geojson(tracks: Tracks) -> str:
    """Return a FeatureCollection: a line for each robot with its stamps, and its last position."""
    features = []
    for robot_id, track in tracks.items():
        last = track[-1]
        common = {"robot_id": robot_id, "class_id": last.class_id}
        if len(track) > 1:  # a GeoJSON line has at least two positions
            line = {"type": "LineString", "coordinates": [_coordinates(e) for e in track]}
            times = {
                "stamps_ns": [e.stamp_ns for e in track],
                "states": [str(e.state) for e in track],
            }
            features.append({"type": "Feature", "properties": common | times, "geometry": line})
        point = {"type": "Point", "coordinates": _coordinates(last)}
        details = {
            "stamp_ns": last.stamp_ns,
            "time": iso_time(last.stamp_ns),
            "state": str(last.state),
            "sigma_m": round(_sigma(last), 4),
        }
        features.append({"type": "Feature", "properties": common | details, "geometry": point})
    return json.dumps({"type": "FeatureCollection", "features": features}, indent=1) + "\n"


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
    sentence = (
        f"{last.class_id}, last position {iso_time(last.stamp_ns)}, {last.state}, "
        f"one sigma {_sigma(last):.2f} m"
    )
    return (
        f"<Placemark>\n<name>{escape(robot_id)}</name>\n"
        f"<description>{escape(sentence)}</description>\n"
        f"<Style><LineStyle><color>{color}</color><width>3</width></LineStyle>"
        f"<IconStyle><color>{color}</color></IconStyle></Style>\n"
        "<gx:Track>\n<altitudeMode>clampToGround</altitudeMode>\n"
        f"{whens}{coords}</gx:Track>\n</Placemark>\n"
    )


def _spaced(estimate: RobotEstimate, separator: str) -> str:
    longitude, latitude = _coordinates(estimate)[:2]
    return separator.join([f"{longitude:.10f}", f"{latitude:.10f}", "0"])


def _coordinates(estimate: RobotEstimate) -> list[float]:
    """Return longitude, latitude and, where it is known, altitude."""
    place = [
        round(math.degrees(estimate.longitude), _DECIMALS),
        round(math.degrees(estimate.latitude), _DECIMALS),
    ]
    if not math.isnan(estimate.altitude):
        place.append(round(estimate.altitude, 4))
    return place


def _sigma(estimate: RobotEstimate) -> float:
    return math.sqrt(float(np.trace(estimate.covariance[:2, :2])) / 2.0)
