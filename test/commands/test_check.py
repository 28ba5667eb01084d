# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss check` on bags: the hover whose answer is known, and what goes wrong."""

from __future__ import annotations

import json
import math

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.commands.check_report import heading_words


def check(capsys, bag, *extra):
    capsys.readouterr()
    status = cli.main(["check", str(bag), *map(str, extra)])
    return status, capsys.readouterr().out


def test_a_hover_is_described_in_words_and_numbers(flight, tmp_path, capsys):
    bag = flight.write(tmp_path / "bag")
    status, out = check(capsys, bag)
    assert status == 0
    for words in ("13.1900000, -59.6400000, 20.0 m above the water", "nose    heading 90 deg",
                  "straight below, image top to 90 deg", "altitude_datum unknown",
                  "reference earth", "10.0 Hz",
                  "not tested  camera meets water: 90.0 deg below the"):  # fmt: skip
        assert words in out, out
    status, out = check(capsys, bag, "--json", "--at", "1.5")
    found = json.loads(out)
    assert found["good"]
    assert found["camera"]["below_horizon_deg"] == pytest.approx(90.0, abs=0.1)
    assert found["camera"]["distance_m"] == pytest.approx(0.03, abs=0.02)  # half a pixel
    assert found["inputs"]["gimbal"]["uses"]["reference"] == "earth"
    assert found["inputs"]["fix"]["count"] == 16
    assert found["inputs"]["fix"]["stamp_to_arrival_s"] == 0.0


OPTICAL = {"x": -math.sqrt(0.5), "y": math.sqrt(0.5), "z": 0.0, "w": 0.0}
"""Right, down, forward of a camera that looks straight down, its image's top ahead."""


def by_tf(parents):
    """Return a change that puts the hover's gimbal on TF."""

    def change(topic, msgtype, fields):
        if topic != "gimbal":
            return topic, msgtype, fields
        stamp = fields["header"]["stamp"]
        links = [
            {
                "header": {"stamp": stamp, "frame_id": parent},
                "child_frame_id": child,
                "transform": {"rotation": {"w": 1.0} if child == "gimbal" else OPTICAL},
            }
            for child, parent in parents.items()
        ]
        return "/tf", "tf2_msgs/msg/TFMessage", {"transforms": links}

    return change


def test_the_camera_s_orientation_may_come_from_tf(flight, replay, tmp_path, capsys):
    own = tmp_path / "own.yaml"
    own.write_text("gimbal: {source: tf, reference: body}\n")
    link = {"gimbal": "base_link", "camera_optical_frame": "gimbal"}
    bag = flight.write(tmp_path / "bag", change=by_tf(link))
    status, out = check(capsys, bag, "--params", own)
    assert status == 0, out
    assert "straight below, image top to 90 deg" in out
    assert "base_frame base_link" in out
    assert replay(bag, tmp_path / "out", "--params", own) == 0
    assert "20 images, 2 robots" in capsys.readouterr().out
    looped = flight.write(
        tmp_path / "loop", change=by_tf(link | {"gimbal": "camera_optical_frame"})
    )
    status, out = check(capsys, looped, "--params", own)
    assert status != 0
    assert "TF has a loop: camera_optical_frame -> gimbal -> camera_optical_frame" in " ".join(
        out.split()
    )


@pytest.mark.parametrize(
    ("pitch_deg", "words"),
    [
        (-90.0, "camera  straight up, image top to 270 deg, 90 deg above the horizon: sees no"),
        (-30.0, "camera  heading 90 deg, 30 deg above the horizon: sees no water"),
        (30.0, "35 m ahead, heading 90 deg, 30 deg below the horizon"),
    ],
)
def test_up_and_down_have_their_names(flight, tmp_path, capsys, pitch_deg, words):
    half = math.radians(pitch_deg) / 2.0

    def tilted(topic, msgtype, fields):
        if topic == "gimbal":  # heading east, FLU: positive pitch looks down
            turn = {"x": 0.0, "y": math.sin(half), "z": 0.0, "w": math.cos(half)}
            fields = fields | {"quaternion": turn}
        return topic, msgtype, fields

    _, out = check(capsys, flight.write(tmp_path / "bag", change=tilted))
    assert words in out, out


def test_a_body_upside_down_is_named(flight, tmp_path, capsys):
    def turned(topic, msgtype, fields):
        if topic == "attitude":
            fields = fields | {"orientation": {"x": 1.0, "y": 0.0, "z": 0.0, "w": 0.0}}
        return topic, msgtype, fields

    status, out = check(capsys, flight.write(tmp_path / "bag", change=turned))
    assert status == 1
    assert "body tilted by 180 deg, upside down" in out


def test_a_missing_input_or_another_type_is_named(flight, tmp_path, capsys):
    bag = flight.write(tmp_path / "a", without=("gimbal",))
    status, out = check(capsys, bag)
    assert status == 1
    assert "gimbal       MISSING: no messages on /gimbal" in out
    assert "`aerial-gnss doctor` shows which topics there are" in out
    assert "camera  unknown: no_gimbal" in out

    status, out = check(capsys, flight.write(tmp_path / "c", without=("camera/camera_info",)))
    assert status == 1  # the pose is known, but there would be no positions
    assert "camera_info  MISSING: no messages on /camera/camera_info" in out

    def float32(topic, msgtype, fields):
        return topic, "std_msgs/msg/Float32" if topic == "height" else msgtype, fields

    status, out = check(capsys, flight.write(tmp_path / "b", change=float32))
    assert status == 1
    assert "/height carries std_msgs/msg/Float32, not std_msgs/msg/Float64" in out


@pytest.mark.parametrize(
    ("heading_deg", "words"),
    [(-1e-9, "0 deg"), (359.6, "0 deg"), (359.4, "359 deg"), (-90.0, "270 deg")],
)
def test_north_is_0_and_never_360(heading_deg, words):
    assert heading_words(math.radians(heading_deg)) == words


def test_bad_values_and_foreign_clocks_are_reported(flight, tmp_path, capsys):
    def spoilt(topic, msgtype, fields):
        if topic == "gimbal":
            fields = fields | {"quaternion": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}}
        if topic == "attitude":
            stamp = fields["header"]["stamp"] | {"sec": fields["header"]["stamp"]["sec"] - 500}
            fields = fields | {"header": fields["header"] | {"stamp": stamp}}
        return topic, msgtype, fields

    status, out = check(capsys, flight.write(tmp_path / "bag", change=spoilt))
    assert status == 1
    assert "30 unusable" in out
    assert "attitude: its stamps are 500.0 s older than their arrival" in out


def test_wrong_input_is_one_sentence(flight, tmp_path, capsys):
    bag = flight.write(tmp_path / "bag", namespace="d1")
    for args, words in (
        ((bag,), "doctor"),
        ((bag, "--namespace", "d1", "--at", "-1"), "--at must be above 0"),
        ((tmp_path / "no",), "does not exist"),
        ((bag, "--seconds", "0"), "--seconds must be above 0"),
    ):
        assert cli.main(["check", *map(str, args)]) == 2
        sentence = capsys.readouterr().err.strip()
        assert words in sentence
        assert "\n" not in sentence
    assert check(capsys, bag, "--namespace", "d1")[0] == 0


def test_a_simulated_flight_states_the_datum_of_its_altitudes(tmp_path, capsys):
    """As for `aerial-gnss replay`."""
    bag = tmp_path / "bag"
    assert cli.main(["simulate", "-o", str(bag), "--no-images", "--duration", "1"]) == 0
    _, out = check(capsys, bag)
    assert "altitude_datum ellipsoid" in out


def test_a_camera_on_a_mast_needs_no_telemetry(flight, tmp_path, capsys):
    params = tmp_path / "mast.yaml"
    params.write_text(
        "fix: {source: constant, latitude_deg: 13.0, longitude_deg: -59.0}\n"
        "gimbal: {source: constant, rpy_deg: [0.0, 30.0, 90.0]}\n"
        "height: {source: constant, value_m: 10.0}\n"
    )
    bag = flight.write(tmp_path / "bag", without=("fix", "attitude", "gimbal", "height"))
    status, out = check(capsys, bag, "--params", params, "--json")
    found = json.loads(out)
    assert status == 0
    assert (found["camera"]["bearing_deg"] + 90.0) % 360.0 == pytest.approx(90.0, abs=0.1)
    assert found["camera"]["distance_m"] == pytest.approx(17.3, abs=0.1)
