# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables and maps: formats, order and names that need quoting."""

from __future__ import annotations

import csv
import json
import math
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.bags.maps import geojson, gpx, iso_time, kml
from aerial_gnss_ros.bags.results import ResultFolder, position_row, rejection_row
from aerial_gnss_ros.bags.tables import read_positions, read_rejections
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.rejection import Reason, Rejection

sys.path.insert(0, str(Path(__file__).parent))

from estimates import ESTIMATE


def test_a_row_of_positions():
    assert ",".join(position_row(ESTIMATE)) == (
        "1735689600123456789,aqua_1,aqua,13.1939387033,-59.6415065636,nan,4,1e-07,0.333333333,"
        "0.250000,-1.000000,coasting"
    )


def test_a_row_of_rejections():
    row = rejection_row(Rejection(5, Reason.ABOVE_HORIZON, 1.25, -3.0))
    assert row == ["5", "above_horizon", "1.250", "-3.000"]


def pose(stamp_ns):
    return CameraPose(stamp_ns, 0.25, -1.0, 20.0, math.nan, np.eye(3))


def test_a_folder_is_in_order_and_its_tables_read_back(tmp_path):
    later = replace(ESTIMATE, stamp_ns=ESTIMATE.stamp_ns + 10, class_id='robot, "blue"')
    second = replace(ESTIMATE, robot_id="aqua_2")
    refused = Rejection(3, Reason.GATED, 1.0, 2.0)
    with ResultFolder(tmp_path) as folder:
        # A clock that went backward: the later stamps come first.
        folder.add(FrameResult(later.stamp_ns, "camera", (later,), (refused,), None, pose(9)))
        both = (ESTIMATE, second)
        folder.add(FrameResult(ESTIMATE.stamp_ns, "camera", both, (), None, pose(4)))
    with (tmp_path / "positions.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [(row["robot_id"], row["class_id"]) for row in table] == [
        ("aqua_1", "aqua"), ("aqua_2", "aqua"), ("aqua_1", 'robot, "blue"'),
    ]  # fmt: skip
    tracks = read_positions(tmp_path / "positions.csv")
    assert {name: len(track) for name, track in tracks.items()} == {"aqua_1": 2, "aqua_2": 1}
    assert tracks["aqua_1"].latitude[0] == pytest.approx(ESTIMATE.latitude, abs=1e-12)
    assert read_rejections(tmp_path / "rejected.csv") == {"gated": 1}
    assert folder.drone.stamps_ns.tolist() == [4, 9]


def test_a_failure_writes_no_tables(tmp_path):
    def fail():
        with ResultFolder(tmp_path):
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert list(tmp_path.iterdir()) == []


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


def test_a_full_disk_names_what_the_user_asked_for(tmp_path):
    """A bag lies in a folder that is partial itself; a limit for files stands for the disk."""
    text = """
import resource, sys
from pathlib import Path
from aerial_gnss_ros.bags.partial import partial
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    with partial(Path(sys.argv[1])) as folder:
        folder.mkdir()
        with partial(folder / "bag") as bag:
            bag.write_bytes(bytes(2000))
except Exception as error:
    print(type(error).__name__, error)
"""
    done = subprocess.run(
        [sys.executable, "-c", text, tmp_path / "out"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"OutputError {tmp_path / 'out'} cannot be written: File too large.\n"
    assert list(tmp_path.iterdir()) == []
