# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss import-dji`: a real flight through a bag, and what is refused."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.detection_frame import empty_detections

HEADER = "OSD.latitude,OSD.longitude,OSD.height [ft],OSD.pitch,OSD.yaw [360],GIMBAL.pitch\n"
START = 1_735_689_600
CAMERA = ("--image-size", "1920x1080", "--focal-length-mm", "4.5", "--sensor-width-mm", "6.17")


def write_log(tmp_path, rows, header=HEADER):
    path = tmp_path / "log.csv"
    path.write_text(header + "".join(row + "\n" for row in rows))
    return path


def run(log, out, *extra):
    return cli.main(["import-dji", str(log), "-o", str(out), *extra])


def read(bag):
    """Return messages by topic with their log times, by an independent reader."""
    found = {}
    with AnyReader([bag]) as reader:
        for connection, log_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((log_ns, message))
    return found


def test_a_row_arrives_on_the_canonical_topics_in_si(tmp_path, capsys):
    log = write_log(tmp_path, ["13.25,-59.5,100,10,90,-90", "13.25,-59.5,50,0,180,-30"])
    assert run(log, tmp_path / "bag", *CAMERA) == 0
    topics = read(tmp_path / "bag")
    assert {name: len(messages) for name, messages in topics.items()} == dict.fromkeys(
        ["/camera/camera_info", "/fix", "/attitude", "/gimbal", "/height"], 2
    )
    assert [t for t, _ in topics["/fix"]] == [START * 10**9, START * 10**9 + 10**8]
    fix = topics["/fix"][0][1]
    assert (fix.latitude, fix.longitude) == (pytest.approx(13.25), pytest.approx(-59.5))
    assert math.isnan(fix.altitude)  # the log names no datum
    assert (fix.header.stamp.sec, fix.header.stamp.nanosec) == (START, 0)
    assert [m.data for _, m in topics["/height"]] == [pytest.approx(30.48), pytest.approx(15.24)]
    half = math.sqrt(0.5)
    body = topics["/attitude"][0][1].orientation  # heading 90: east; nose up 10 deg: pitch -10
    np.testing.assert_allclose(
        [body.x, body.y, body.z, body.w],
        [0.0, -math.sin(math.radians(5)), 0.0, math.cos(math.radians(5))], atol=1e-12,
    )  # fmt: skip
    down = topics["/gimbal"][0][1].quaternion  # pitch -90 is straight down: +90 deg about left
    np.testing.assert_allclose([down.x, down.y, down.z, down.w], [0.0, half, 0.0, half])
    info = topics["/camera/camera_info"][0][1]
    assert (info.width, info.height) == (1920, 1080)
    np.testing.assert_allclose(info.k[[0, 4]], 4.5 / 6.17 * 1920)
    out = " ".join(capsys.readouterr().out.split())
    for words in ("feet, converted to m", "earth-referenced", "compass heading", "row number at",
                  "gimbal yaw: the aircraft's heading", "nothing", "/gimbal "):  # fmt: skip
        assert words in out


def test_refused_rows_are_listed_by_reason(tmp_path, capsys):
    rows = [f"13.2,-59.6,30,0,0,{pitch}" for pitch in (-60, 999, -60, -361, -60)]
    assert run(write_log(tmp_path, rows), tmp_path / "bag") == 0
    assert "2 rows: an angle out of range (lines 3, 5)" in " ".join(capsys.readouterr().out.split())
    assert len(read(tmp_path / "bag")["/height"]) == 3
    assert run(write_log(tmp_path, rows), tmp_path / "again", "--json", "--namespace", "d1") == 0
    summary = json.loads(capsys.readouterr().out)
    assert "import again with --water-level" in summary["guesses"][0]
    assert summary["refused_lines"] == {"an angle out of range": [3, 5]}
    assert summary["messages"]["/d1/height"] == 3


def test_a_flight_from_a_cliff_keeps_its_rows_and_says_what_to_set(tmp_path, capsys):
    """Take-off 15 m above the water, then down to 4 m above it: 36 ft below home."""
    rows = [f"13.2,-59.6,{height},0,0,-90" for height in np.linspace(30, -36, 1342)]
    log = write_log(tmp_path, rows)
    assert run(log, tmp_path / "bag") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "refused nothing" in out
    assert "gap" not in out
    assert "down to -11.0 m, which is below the take-off point" in out
    assert "height: {reference: home}, water_level: {value_m: -12}" in out
    topics = read(tmp_path / "bag")
    assert len(topics["/height"]) == len(topics["/fix"]) == 1342
    assert "/water_level" not in topics
    assert cli.main(["check", str(tmp_path / "bag")]) == 1  # below the water, as far as it knows

    # With the level in the bag replay and check need no parameters.
    assert run(log, tmp_path / "level", "--water-level", "-15", *CAMERA) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "-15 m above the take-off point (--water-level)" in out
    assert "below the take-off point" not in out
    assert [m.data for _, m in read(tmp_path / "level")["/water_level"]] == [-15.0]
    assert cli.main(["check", str(tmp_path / "level"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["drone"]["height_m"] == pytest.approx(15.0 - 36.0 * 0.3048, abs=0.05)

    assert run(log, tmp_path / "wrong", "--water-level", "15") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "down to -26.0 m above the water with this --water-level" in out
    assert "check its sign" in out


def test_rows_too_far_apart_to_interpolate_between_are_reported(tmp_path, capsys):
    log = write_log(tmp_path, ["13.25,-59.5,100,10,90,-90"] * 4)
    assert run(log, tmp_path / "slow", "--rate", "0.3") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert (
        "rows are 3.3 s apart, more than attitude.max_gap (2.5 s) and gimbal.max_gap (2.5 s) allows"
        in out
    )
    assert run(log, tmp_path / "fast") == 0
    assert "images between them give no positions" not in capsys.readouterr().out


def test_the_same_log_gives_the_same_bytes(tmp_path):
    log = write_log(tmp_path, ["13.25,-59.5,100,10,90,-90", "13.25,-59.5,50,0,180,-30"])
    for name in ("a", "b"):
        assert run(log, tmp_path / name / "bag") == 0
    a, b = ((tmp_path / name / "bag/bag.mcap").read_bytes() for name in ("a", "b"))
    assert a == b


@pytest.mark.parametrize(
    ("rows", "extra", "expected"),
    [
        (["13.2,-59.6,33000,0,0,-60"] * 3, (), "3 rows: height out of range"),
        (["13.2,-59.6,30,0,0,-60"] * 3, ("--start", "1e300"), "within 0 and 2100000000 s"),
        (["13.2,-59.6,30,0,0,-60"] * 3, ("--water-level", "nan"), "within -500 and 10000 m"),
        (["13.2,-59.6,30,0,0,-60"] * 3, ("--rate", "1e-9"), "2 rows: time out of range"),
        (["13.2,-59.6,30,0,0,-60"] * 3, CAMERA[:2], "--focal-length-mm, --sensor-width-mm too"),
        (["13.2,-59.6,30,0,0,-60"] * 3, ("--image-size", "HD", *CAMERA[2:]), "such as 1920x1080"),
        (["13.2,-59.6,30,0,0,-60"] * 3, ("--rate", "0"), "--rate must be above 0 Hz"),
        (["13.2,-59.6,30,0,0,-60"] * 3, ("--start", "nan"), "--start must be a Unix time"),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_nothing(tmp_path, capsys, rows, extra, expected):
    assert run(write_log(tmp_path, rows), tmp_path / "bag", *extra) == 2
    sentence = capsys.readouterr().err.strip()
    assert expected in sentence
    assert "\n" not in sentence
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_missing_logs_wrong_columns_and_existing_bags_are_refused(tmp_path, capsys):
    assert run(tmp_path / "no.csv", tmp_path / "bag") == 2
    assert "no.csv" in capsys.readouterr().err
    assert run(write_log(tmp_path, ["1,2"], "a,b\n"), tmp_path / "bag") == 2
    assert "has no column for latitude" in capsys.readouterr().err
    (tmp_path / "bag").mkdir()
    assert run(write_log(tmp_path, []), tmp_path / "bag") == 2
    assert "bag exists already" in capsys.readouterr().err


def axis_distances(bag, latitude, longitude):
    """Return how far the camera's axis meets the water from a place, for every recorded fix, m.

    Through the same feed and estimator as in flight: an image without boxes at each fix.
    """
    config = estimator_config({})
    estimator = Estimator(config)
    inputs = {"/" + s.topic: s for s in Feed(config, estimator).subscriptions}
    results, camera = [], None
    with open_bag(bag) as reader:
        for recorded in reader.messages(set(inputs)):
            message = recorded.message()
            inputs[recorded.topic].handle(message, recorded.log_ns)
            if recorded.topic == "/camera/camera_info":
                camera = canonical.camera(message, rectified=False)
            if recorded.topic == "/fix":
                estimator.add_detections(empty_detections(recorded.log_ns))
            results += estimator.advance(recorded.log_ns)
    results += estimator.flush()
    axis = camera.K[:2, 2]
    distances = []
    for result in results:
        points = locate(result.pose, camera, axis, config.noise, config)
        distance, _, _ = geodesic_inverse(
            points.latitude[0], points.longitude[0], latitude, longitude
        )
        distances.append(float(distance))
    return np.array(distances)


def test_the_axis_of_the_real_flight_stays_on_the_robot(shared_data, tmp_path):
    assert run(shared_data / "dji_single_robot.csv", tmp_path / "bag", *CAMERA) == 0
    place = np.radians([13.1939387032944, -59.6415065636197])
    distances = axis_distances(tmp_path / "bag", *place)
    assert len(distances) == 663
    assert np.isfinite(distances).all()
    assert np.median(distances) < 0.6


def test_the_long_real_flight_is_imported_whole(shared_data, tmp_path, capsys):
    assert run(shared_data / "dji_tracking.csv", tmp_path / "bag", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["rows"] == 12002
    assert summary["duration_s"] == pytest.approx(1200.1)
    with open_bag(tmp_path / "bag") as reader:
        assert {t.name: t.count for t in reader.topics.values()} == dict.fromkeys(
            ["/attitude", "/fix", "/gimbal", "/height"], 12002
        )
