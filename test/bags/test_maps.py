# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Maps of robots' tracks: GeoJSON, KML and GPX."""

from __future__ import annotations

import json
import math
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest

from aerial_gnss_ros.bags.maps import geojson, gpx, iso_time, kml

sys.path.insert(0, str(Path(__file__).parent))

from estimates import ESTIMATE


def test_a_single_position_is_a_point_without_a_line():
    features = json.loads(geojson({"aqua_1": [ESTIMATE]}))["features"]
    [point] = features
    assert point["geometry"] == {
        "type": "Point", "coordinates": [-59.6415065636, 13.1939387033],
    }  # fmt: skip
    assert point["properties"]["time"] == "2025-01-01T00:00:00.123Z"
    assert point["properties"]["sigma_m"] == pytest.approx(math.sqrt((4 + 1 / 3) / 2), abs=1e-4)
    known = replace(ESTIMATE, altitude=-40.5)
    [point] = json.loads(geojson({"aqua_1": [known]}))["features"]
    assert point["geometry"]["coordinates"][2] == -40.5


def test_kml_escapes_names():
    assert "a &lt;b&gt; &amp; c, last position" in kml(
        {"aqua_1": [replace(ESTIMATE, class_id="a <b> & c")]}
    )


def test_times_before_and_after_the_epoch():
    assert iso_time(0) == "1970-01-01T00:00:00.000Z"
    assert iso_time(-1_000_000) == "1969-12-31T23:59:59.999Z"


def test_a_line_over_the_antimeridian_is_cut_there():
    places = [(10.0, 179.0), (12.0, -179.0), (12.0, -178.0)]
    track = [
        replace(ESTIMATE, latitude=math.radians(a), longitude=math.radians(b)) for a, b in places
    ]
    [line, point] = json.loads(geojson({"aqua_1": track}))["features"]
    assert line["geometry"] == {
        "type": "MultiLineString",
        "coordinates": [
            [[179.0, 10.0], [180.0, 11.0]],
            [[-180.0, 11.0], [-179.0, 12.0], [-178.0, 12.0]],
        ],
    }
    assert (line["properties"]["name"], point["properties"]["name"]) == ("aqua_1", "aqua_1")
    assert line["properties"]["style"]["color"] == "#0072b2"


def test_gpx_has_a_track_and_the_last_place_of_each_robot():
    later = replace(ESTIMATE, stamp_ns=ESTIMATE.stamp_ns + 10**9, class_id="a <b>")
    space = "{http://www.topografix.com/GPX/1/1}"
    root = ET.fromstring(gpx({"aqua_1": [ESTIMATE, later]}))  # noqa: S314 - our own
    assert (root.tag, root.get("version")) == (space + "gpx", "1.1")
    assert [child.tag for child in root] == [space + "wpt", space + "trk"]  # the schema's order
    points = root.findall(f".//{space}trkpt")
    assert [p.get("lat") for p in points] == ["13.1939387033"] * 2
    assert [p.find(space + "time").text for p in points] == [
        "2025-01-01T00:00:00.123Z", "2025-01-01T00:00:01.123Z",
    ]  # fmt: skip
    assert root.find(f"{space}trk/{space}type").text == "a <b>"
    assert root.find(f".//{space}ele") is None
