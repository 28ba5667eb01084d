# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss replay`: outputs of the contract, the same bytes, and one sentence for bad input."""

from __future__ import annotations

import csv
import hashlib
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pymap3d
import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.text.sentences import counted

COLUMNS = (
    "stamp_ns,robot_id,class_id,latitude_deg,longitude_deg,altitude_m,var_east_m2,"
    "cov_east_north_m2,var_north_m2,velocity_east_mps,velocity_north_mps,state"
)


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def ellipsoid(tmp_path):
    path = tmp_path / "datum.yaml"
    path.write_text("estimator: {ros__parameters: {fix: {altitude_datum: ellipsoid}}}\n")
    return path


@pytest.mark.parametrize("method", ["filter", "single"])
def test_positions_are_where_the_robots_are(tmp_path, flight, ellipsoid, method, replay):
    out = tmp_path / "out"
    assert (
        replay(flight.write(tmp_path / "bag"), out, "--params", ellipsoid, "--method", method) == 0
    )
    table = rows(out / "positions.csv")
    assert (out / "positions.csv").read_text().splitlines()[0] == COLUMNS
    order = [(int(row["stamp_ns"]), row["robot_id"]) for row in table]
    assert order == sorted(order)
    assert len(table) >= 2 * (flight.images - 5)  # all but those before confirmation
    assert {row["class_id"] for row in table} == {"aqua"}
    assert {row["state"] for row in table} == {"confirmed"}
    found = {
        row["robot_id"]: pymap3d.geodetic2enu(
            float(row["latitude_deg"]), float(row["longitude_deg"]), float(row["altitude_m"]),
            flight.latitude, flight.longitude, flight.altitude,
        )
        for row in table
    }  # fmt: skip
    assert sorted(found) == ["aqua_1", "aqua_2"]
    by_north = np.array(sorted(found.values(), key=lambda place: -place[1]))
    truth = np.array(sorted(flight.true_east_north(), key=lambda place: -place[1]))
    np.testing.assert_allclose(by_north[:, :2], truth, atol=1e-3)
    np.testing.assert_allclose(by_north[:, 2], -20.0, atol=1e-3)


@pytest.mark.usefixtures("drawn")
def test_every_output_of_the_contract_is_there(tmp_path, flight, capsys, replay):
    out = tmp_path / "out"
    assert replay(flight.write(tmp_path / "bag"), out, "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    table = rows(out / "positions.csv")
    assert {path.name for path in out.iterdir()} == {
        "positions.csv", "rejected.csv", "bag", "positions.geojson", "positions.kml",
        "positions.gpx", "platform.csv", "report.html",
    }  # fmt: skip
    assert summary["frames"] == flight.images
    assert summary["positions"] == len(table)
    assert summary["detections_from"] == "recorded detections"
    assert (out / "rejected.csv").read_text() == "stamp_ns,reason,u_px,v_px\n"
    check_maps(out, table)
    check_bag(out, table, flight.images)
    assert "aqua_1" in (out / "report.html").read_text()


def check_maps(out, table):
    last = [row for row in table if row["robot_id"] == "aqua_1"][-1]
    place = [float(last["longitude_deg"]), float(last["latitude_deg"])]
    features = json.loads((out / "positions.geojson").read_text())["features"]
    mine = [f for f in features if f["properties"]["robot_id"] == "aqua_1"]
    assert [f["geometry"]["type"] for f in mine] == ["LineString", "Point"]
    assert mine[0]["geometry"]["coordinates"][-1] == mine[1]["geometry"]["coordinates"] == place
    assert mine[0]["properties"]["stamps_ns"][-1] == int(last["stamp_ns"])
    names = {"k": "http://www.opengis.net/kml/2.2", "gx": "http://www.google.com/kml/ext/2.2"}
    root = ET.parse(out / "positions.kml").getroot()  # noqa: S314 - our own
    assert [e.text for e in root.findall(".//k:Placemark/k:name", names)] == ["aqua_1", "aqua_2"]
    track = root.find(".//gx:Track", names)
    coordinates = [float(v) for v in track.findall("gx:coord", names)[-1].text.split()]
    assert coordinates == [*place, 0.0]
    assert track.findall("k:when", names)[0].text.startswith("1970-01-01T00:16:4")


def check_bag(out, table, images):
    with AnyReader([out / "bag"]) as reader:
        topics = {c.topic: c for c in reader.connections}
        geo_poses = [
            (t, reader.deserialize(raw, c.msgtype))
            for c, t, raw in reader.messages([topics["/robots/aqua_1/geo_pose"]])
        ]
        maps = [
            reader.deserialize(raw, c.msgtype).geojson
            for c, _, raw in reader.messages([topics["/robots/geojson"]])
        ]
    assert sorted(topics) == [
        "/map_datum", "/overview",
        "/robots/aqua_1/fix", "/robots/aqua_1/geo_pose", "/robots/aqua_1/odom",
        "/robots/aqua_2/fix", "/robots/aqua_2/geo_pose", "/robots/aqua_2/odom",
        "/robots/geojson", "/robots/markers", "/tf", "/tf_static",
    ]  # fmt: skip
    assert topics["/map_datum"].msgcount == topics["/robots/geojson"].msgcount == 1
    assert maps == [(out / "positions.geojson").read_text()]
    assert topics["/robots/markers"].msgcount == images
    for topic, connection in topics.items():
        [qos] = connection.ext.offered_qos_profiles
        assert (qos.durability is QosDurability.TRANSIENT_LOCAL) == (topic != "/tf")
    mine = [row for row in table if row["robot_id"] == "aqua_1"]
    assert [t for t, _ in geo_poses] == [int(row["stamp_ns"]) for row in mine]
    for (_, message), row in zip(geo_poses, mine, strict=True):
        position = message.pose.pose.position
        assert f"{position.latitude:.10f}" == row["latitude_deg"]
        assert f"{message.pose.covariance[7]:.9g}" == row["var_east_m2"]


def digest(folder):
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.mark.usefixtures("drawn")
def test_the_same_input_gives_the_same_bytes(tmp_path, flight, replay):
    bag = flight.write(tmp_path / "bag")
    for name in ("a", "b"):
        assert replay(bag, tmp_path / name / "out") == 0
    assert digest(tmp_path / "a/out") == digest(tmp_path / "b/out")


def test_bags_that_belong_together_give_what_one_gives(tmp_path, flight, replay):
    whole = flight.write(tmp_path / "whole")
    boxes = flight.write(tmp_path / "boxes", without=("fix", "attitude", "gimbal", "height",
                                                      "camera/camera_info"))  # fmt: skip
    rest = flight.write(tmp_path / "rest", without=("detections",))
    assert replay(whole, tmp_path / "one") == replay([boxes, rest], tmp_path / "two") == 0
    one, two = ((tmp_path / n / "positions.csv").read_bytes() for n in ("one", "two"))
    assert one == two


@pytest.mark.usefixtures("drawn")
def test_the_report_has_errors_where_the_bag_has_truth(tmp_path, flight, replay):
    bag = flight.write(tmp_path / "bag")
    (east, north), _ = flight.true_east_north()
    latitude, longitude, _ = pymap3d.enu2geodetic(
        east, north + 0.25, -20.0, flight.latitude, flight.longitude, flight.altitude
    )
    with BagWriter(tmp_path / "truth") as truth:
        for stamp in flight.stamps():
            fields = {
                "header": header_fields(stamp, ""),
                "latitude": latitude,
                "longitude": longitude,
            }
            truth.write("truth/robots/blue/fix", "sensor_msgs/msg/NavSatFix", stamp, fields)
    assert replay([bag, tmp_path / "truth"], tmp_path / "out") == 0
    report = (tmp_path / "out/report.html").read_text()
    assert "Error against truth" in report
    [row] = re.findall(r"<tr><td>blue</td>.*?</tr>", report)
    assert re.findall(r"<td>(0\.\d+)</td>", row)[:3] == ["0.25"] * 3  # median, p95, RMSE


def test_a_namespace_and_a_vehicle(tmp_path, flight, replay):
    bag = flight.write(tmp_path / "bag", namespace="drone1")
    assert replay(bag, tmp_path / "out", "--namespace", "drone1", "--vehicle", "generic") == 0
    with AnyReader([tmp_path / "out/bag"]) as reader:
        spaces = {c.topic.split("/")[1] for c in reader.connections}
        assert spaces == {"drone1", "tf", "tf_static"}


def test_images_are_looked_at_where_there_are_no_detections(
    tmp_path, flight, detector, capsys, replay
):
    assert replay(flight.write(tmp_path / "boxes"), tmp_path / "recorded") == 0
    assert detector.calls == 0
    bag = flight.write(tmp_path / "images", images=True)
    capsys.readouterr()
    assert replay(bag, tmp_path / "detected", "--json") == 0
    assert detector.calls == flight.images
    summary = json.loads(capsys.readouterr().out)
    assert summary["detections_from"] == "images, two robots, on paper"
    recorded, detected = (tmp_path / n / "positions.csv" for n in ("recorded", "detected"))
    assert recorded.read_bytes() == detected.read_bytes()
    # The boxes found are kept, so that another replay needs no images.
    again = tmp_path / "again"
    assert replay([bag, tmp_path / "detected/bag"], again) == 0
    assert detector.calls == flight.images
    assert (again / "positions.csv").read_bytes() == detected.read_bytes()


def test_a_model_asks_for_detection_even_where_boxes_are_recorded(
    tmp_path, flight, detector, replay
):
    a = flight.write(tmp_path / "a")
    b = flight.write(tmp_path / "b", images=True, without=("fix", "height", "gimbal", "attitude",
                                                           "camera/camera_info"))  # fmt: skip
    assert replay([a, b], tmp_path / "out", "--model", "x.onnx") == 0
    assert detector.calls == flight.images


@pytest.mark.parametrize("damaged", [(1,), (5, 7)])
def test_damaged_images_are_counted_and_reported(
    tmp_path, flight, detector, capsys, replay, damaged
):
    seen = []

    def cut_off(topic, msgtype, fields):
        if topic == "camera/image_raw":
            seen.append(topic)
            if len(seen) in damaged:
                fields = fields | {"data": b"\x00" * 10}
        return topic, msgtype, fields

    bag = flight.write(tmp_path / "bag", images=True, change=cut_off)
    assert replay(bag, tmp_path / "out") == 0
    assert detector.calls == flight.images - len(damaged)
    captured = capsys.readouterr()
    assert f"unusable images: {len(damaged)}" in captured.out
    assert f"{counted(len(damaged), 'image')} skipped: /camera/image_raw: " in captured.err
    assert "was cut off" in captured.err


def test_refused_detections_are_listed_with_their_pixels(tmp_path, flight, capsys, replay):
    low = replace(flight, robots=((-100.0, 0.0), (5000.0, 0.0)))
    assert replay(low.write(tmp_path / "bag"), tmp_path / "out") == 0
    table = rows(tmp_path / "out/rejected.csv")
    assert len(table) == flight.images
    assert {(row["u_px"], row["v_px"]) for row in table} == {("5320.000", "240.000")}
    [reason] = {row["reason"] for row in table}
    assert re.search(rf"{reason} +{flight.images}  ", capsys.readouterr().out)


def test_a_depth_that_the_bag_lacks_is_reported(tmp_path, flight, capsys, replay):
    wanted = tmp_path / "depth.yaml"
    wanted.write_text("depth: {topics: [aqua=sonar/depth]}\n")
    bag = flight.write(tmp_path / "bag")
    assert replay(bag, tmp_path / "out", "--params", wanted) == 0
    assert "no messages on /sonar/depth, which depth.topics names" in capsys.readouterr().err
    assert replay(bag, tmp_path / "plain") == 0
    assert "depth.topics" not in capsys.readouterr().err


@pytest.mark.usefixtures("drawn")
def test_nothing_found_is_a_result_too(tmp_path, flight, capsys, replay):
    empty = replace(flight, robots=())
    assert replay(empty.write(tmp_path / "bag"), tmp_path / "out") == 0
    assert (tmp_path / "out/positions.csv").read_text() == COLUMNS + "\n"
    assert "20 images, 0 robots, 0 positions" in capsys.readouterr().out
    assert rows(tmp_path / "out/rejected.csv") == []


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("flight.bag", ["--dst-typestore", "ros1_noetic", "--exclude-topic", "/detections"]),
        ("humble", ["--dst-storage", "sqlite3", "--dst-version", "8"]),
        ("packed", ["--dst-storage", "sqlite3", "--compress", "zstd"]),
    ],
)
def test_bags_of_other_kinds_give_the_same_positions(
    tmp_path, flight, detector, name, options, replay
):
    bag = flight.write(tmp_path / "bag")
    images = flight.write(tmp_path / "images", images=True)
    source = images if name.endswith(".bag") else bag
    other = tmp_path / name
    convert = [sys.executable, "-m", "rosbags.convert", "--src", source, "--dst", other, *options]
    subprocess.run(convert, check=True, capture_output=True)
    assert replay(bag, tmp_path / "a") == replay(other, tmp_path / "b") == 0
    assert detector.calls == (flight.images if name.endswith(".bag") else 0)
    a, b = ((tmp_path / n / "positions.csv").read_bytes() for n in "ab")
    assert a == b


@pytest.mark.parametrize("degrees", [1.0, 3.0])
def test_an_origin_of_another_site_is_refused(tmp_path, flight, refusal, degrees):
    origin = tmp_path / "origin.yaml"
    latitude, longitude = flight.latitude + degrees, flight.longitude
    origin.write_text(
        "estimator: {ros__parameters: {map: "
        f"{{latitude_deg: {latitude}, longitude_deg: {longitude}}}}}}}\n"
    )
    sentence = refusal(flight.write(tmp_path / "bag"), tmp_path / "out", "--params", origin)
    assert f"{degrees * 111.2:.0f} km from the drone" in sentence
    assert "correct map.latitude_deg and map.longitude_deg" in sentence
