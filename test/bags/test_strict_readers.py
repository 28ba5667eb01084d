# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What replay writes is read by other programs' strict parsers, whatever classes are called."""

from __future__ import annotations

import csv
import io
import json
import math
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.bags.maps import geojson, gpx, kml
from aerial_gnss_ros.bags.results import ResultFolder
from aerial_gnss_ros.bags.tables import read_positions
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult

sys.path.insert(0, str(Path(__file__).parent))

from estimates import ESTIMATE

WHY = "pip install '.[test]'"
geojson_reader = pytest.importorskip("geojson", reason=WHY)
gpxpy = pytest.importorskip("gpxpy", reason=WHY)
fastkml = pytest.importorskip("fastkml", reason=WHY)
etree = pytest.importorskip("lxml.etree", reason=WHY)

CONTROLS = "".join(map(chr, range(32)))
CLASSES = [
    "aqua",
    f"a{CONTROLS}b",
    "del\x7f\x85",
    "lone\ud800surrogate",
    "none\ufffe\uffff",
    "]]><script>&amp;\"'",
    '=HYPERLINK("http://x","y")',
    "-2+3",
    "@SUM(A1)",
    "\t=1",
    "row\r\nbreak",
    "机器人 🤖",
    "",
]
TRACKS = {
    f"robot_{i}": [
        replace(ESTIMATE, class_id=name, robot_id=f"robot_{i}"),
        replace(ESTIMATE, class_id=name, robot_id=f"robot_{i}", stamp_ns=ESTIMATE.stamp_ns + 10**9),
    ]
    for i, name in enumerate(CLASSES)
}


@pytest.mark.parametrize("write", [gpx, kml])
def test_xml_is_well_formed(write, tmp_path):
    text = write(TRACKS).encode("utf-8")
    etree.fromstring(text, etree.XMLParser(recover=False))
    if shutil.which("xmllint") is None:
        pytest.skip("xmllint is not installed (Debian's libxml2-utils)")
    file = tmp_path / "map.xml"
    file.write_bytes(text)
    done = subprocess.run(
        ["xmllint", "--noout", str(file)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_gpx_library_finds_every_robot():
    found = gpxpy.parse(gpx(TRACKS))
    assert [track.name for track in found.tracks] == list(TRACKS)
    assert [point.name for point in found.waypoints] == list(TRACKS)
    [segment] = found.tracks[0].segments
    places = [(point.latitude, point.longitude) for point in segment.points]
    assert places == [(13.1939387033, -59.6415065636)] * 2
    assert found.tracks[1].type == "a" + "\ufffd" * 32 + "b"
    assert found.tracks[-2].type == "机器人 🤖"


def test_gpx_ends_before_the_antimeridian():
    """GPX 1.1: longitudes are at least -180 and less than 180."""
    at = replace(ESTIMATE, longitude=math.pi)
    [point] = gpxpy.parse(gpx({"aqua_1": [at]})).waypoints
    assert point.longitude == -180.0


def test_a_kml_library_finds_every_robot():
    found = fastkml.KML.from_string(kml(TRACKS).partition("\n")[2])  # it takes no declaration
    placemarks = list(fastkml.utils.find_all(found, of_type=fastkml.Placemark))
    assert [placemark.name for placemark in placemarks] == list(TRACKS)
    assert placemarks[5].description.startswith("]]><script>&amp;\"', last position 2025-01-01T")
    place = {"k": "http://www.opengis.net/kml/2.2"}
    root = etree.fromstring(kml(TRACKS).encode())
    style = root.find(".//k:Style", place)
    assert [etree.QName(child).localname for child in style] == ["IconStyle", "LineStyle"]


def test_geojson_is_strict_json_and_valid():
    text = geojson(TRACKS)
    text.encode("utf-8")
    found = geojson_reader.loads(text)
    assert found.is_valid, found.errors()
    names = [feature["properties"]["robot_id"] for feature in found["features"][::2]]
    assert names == list(TRACKS)
    for feature in found["features"]:
        feature["properties"]["class_id"].encode("utf-8")  # no lone surrogate behind an escape

    def refuse(word):
        raise AssertionError(word)

    json.loads(text, parse_constant=refuse)
    infinite = replace(ESTIMATE, altitude=math.inf)
    json.loads(geojson({"aqua_1": [infinite]}), parse_constant=refuse)


def test_a_line_along_the_antimeridian_has_no_width_to_divide_by():
    track = [replace(ESTIMATE, longitude=side * math.pi) for side in (1.0, -1.0, 1.0)]
    found = geojson_reader.loads(geojson({"aqua_1": track}))
    assert found["features"][0]["geometry"]["type"] == "MultiLineString"


def test_positions_are_a_table_without_formulas(tmp_path):
    with ResultFolder(tmp_path) as folder:
        for track in TRACKS.values():
            for estimate in track:
                pose = CameraPose(estimate.stamp_ns, 0.25, -1.0, 20.0, math.nan, np.eye(3))
                folder.add(FrameResult(estimate.stamp_ns, "camera", (estimate,), (), None, pose))
    text = (tmp_path / "positions.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == 2 * len(CLASSES)
    assert len(text.splitlines()) == len(rows) + 1  # a line each, for simple readers, too
    for row in rows:
        assert not row["class_id"].startswith(("=", "+", "-", "@", "\t", "\r"))
        assert None not in row
    by_robot = {row["robot_id"]: row["class_id"] for row in rows}
    assert by_robot["robot_6"] == '\'=HYPERLINK("http://x",\'"y")'.replace(",'", ",")
    assert by_robot["robot_7"] == "'-2+3"
    assert by_robot["robot_11"] == "机器人 🤖"
    assert sorted(read_positions(tmp_path / "positions.csv")) == sorted(TRACKS)
