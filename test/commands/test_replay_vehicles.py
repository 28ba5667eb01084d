# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss replay --vehicle`: recordings of each vehicle, read with their own definitions."""

from __future__ import annotations

import csv
import importlib.util
import math
import sys

import pymap3d
import pytest

from aerial_gnss_ros.bags import typestore as shipped
from aerial_gnss_ros.bags import writer

START = 1_700_000_000 * 10**9
STEP = 100_000_000
ONE = "/**/estimator: {ros__parameters: {tracks: {confirm_hits: 1}, method: single}}\n"


@pytest.fixture(scope="module")
def cross(repository):
    """Return the module with scenes and encodings; test folders are no packages."""
    path = repository / "test" / "adapters" / "test_cross_vehicle.py"
    spec = importlib.util.spec_from_file_location("aerial_gnss_tests_cross", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def recorded(cross, tmp_path):
    """Return a function that writes a flight of one scene, as a vehicle would be recorded."""

    def record(name, scene, *, change=lambda topic, msgtype, fields: (topic, msgtype, fields)):
        vehicle = cross.VEHICLES[name]
        config = cross.config_of(vehicle, scene)
        topics = {
            (s.name if s.name != "detections" else "boxes"): s.topic
            for s in cross.Feed(config, None).subscriptions
        }
        bag = tmp_path / "bag"
        store = cross.types.extended()  # itself calls what is replaced below
        with pytest.MonkeyPatch.context() as patch:  # only while writing: reading is on its own
            patch.setattr(shipped, "typestore", lambda: store)
            patch.setattr(writer, "typestore", lambda: store)
            with writer.BagWriter(bag, namespace="drone1") as out:
                for i in range(6):
                    now = START + i * STEP
                    header = cross.messages_of.header(now)
                    sent = [
                        (
                            "camera_info",
                            "sensor_msgs/msg/CameraInfo",
                            cross.INFO | {"header": header},
                        )
                    ]
                    sent += [
                        (key, kind, encode(scene, now))
                        for key, (kind, encode) in vehicle.messages.items()
                    ]
                    done = set()
                    for key, kind, fields in sent:
                        row = change(topics[key], kind, fields)
                        if row and row[0] not in done:  # one pose is both position and attitude
                            done.add(row[0])
                            out.write(row[0], row[1], now, row[2])
                    boxes = cross.boxes(scene, lambda _kind, fields: fields)
                    image = cross.messages_of.header(now + STEP // 2)
                    kind = "vision_msgs/msg/Detection2DArray"
                    out.write("detections", kind, now + STEP // 2, boxes | {"header": image})
        return bag

    return record


@pytest.fixture
def arguments(tmp_path):
    """Return the arguments that every replay here has."""
    params = tmp_path / "params.yaml"
    params.write_text(ONE)
    return ["--params", params, "--namespace", "drone1"]


@pytest.mark.parametrize(
    "name",
    [
        "mavros_px4, flags heading",
        "mavros_ardupilot",
        "px4_uxrce, flags heading",
        "dji_psdk",
        "anafi",
    ],
)
def test_recorded_vehicles_find_the_robot(cross, recorded, replay, arguments, tmp_path, name):
    scene = cross.surveyed(cross.SCENES["nose33_down45"])

    def newer(topic, msgtype, fields):  # as PX4 names it since 1.17
        return (topic + "_v1" if topic.endswith("local_position") else topic), msgtype, fields

    bag = recorded(name, scene, change=newer)
    profile = cross.VEHICLES[name].profile
    assert replay(bag, tmp_path / "out", "--vehicle", profile, *arguments) == 0
    with (tmp_path / "out" / "positions.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "confirmed"]
    assert len(rows) == 5
    latitude, longitude, _ = scene.robot()
    for row in rows:
        found = float(row["latitude_deg"]), float(row["longitude_deg"]), 0.0
        east, north, _ = pymap3d.geodetic2enu(*found, latitude, longitude, 0.0)
        assert math.hypot(east, north) < 0.01


def test_position_and_attitude_of_one_topic_are_both_read(
    cross, recorded, replay, arguments, tmp_path
):
    scene = cross.surveyed(cross.SCENES["nose33_down45"])
    bag = recorded("ardupilot_dds", scene)
    mount = cross.messages_of.mount_rpy_deg(scene)["gimbal.mount_rpy_deg"]
    own = tmp_path / "mount.yaml"
    own.write_text(f"gimbal: {{mount_rpy_deg: {mount}}}\n")
    more = ["--vehicle", "ardupilot_dds", "--params", own, *arguments]
    assert replay(bag, tmp_path / "out", *more) == 0
    with (tmp_path / "out" / "positions.csv").open(newline="") as file:
        row = next(csv.DictReader(file))
    latitude, longitude, _ = scene.robot()
    found = float(row["latitude_deg"]), float(row["longitude_deg"]), 0.0
    east, north, _ = pymap3d.geodetic2enu(*found, latitude, longitude, 0.0)
    assert math.hypot(east, north) < 0.01
    assert float(row["altitude_m"]) == pytest.approx(scene.water_m, abs=0.01)


def test_a_topic_that_never_appears_is_named(cross, recorded, refusal, arguments, tmp_path):
    scene = cross.surveyed(cross.SCENES["nose33_down45"])
    bag = recorded(
        "px4_uxrce, flags heading",
        scene,
        change=lambda topic, kind, fields: (topic, kind, fields) if "gimbal" not in topic else None,
    )
    said = refusal(bag, tmp_path / "out", "--vehicle", "px4_uxrce", *arguments)
    assert (
        "lacks /drone1/fmu/out/gimbal_device_attitude_status (gimbal, "
        "px4_msgs/msg/GimbalDeviceAttitudeStatus)" in said
    )


def test_another_type_than_the_profiles_is_named(cross, recorded, refusal, arguments, tmp_path):
    scene = cross.surveyed(cross.SCENES["nose33_down45"])

    def double(topic, kind, fields):
        wide = kind == "std_msgs/msg/Float32"
        return topic, "std_msgs/msg/Float64" if wide else kind, fields

    bag = recorded("anafi", scene, change=double)
    said = refusal(bag, tmp_path / "out", "--vehicle", "anafi", *arguments)
    assert "altitude_above_to has message type std_msgs/msg/Float64, but height is set to" in said
    assert "set height.type or height.topic in --params, or choose another --vehicle" in said


@pytest.mark.parametrize(
    ("group", "values", "sentence"),
    [
        (
            "gimbal",
            {"quaternion": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}},
            "has length 0 instead",
        ),
        ("gimbal", {"quaternion": {"x": 0.5, "y": 0.0, "z": 0.0, "w": 0.0}}, "has length 0.5 inst"),
        ("height", {"data": math.nan}, "A message on height is of no use: its value is nan"),
        ("fix", {"latitude": math.nan}, "is not on Earth"),
    ],
)
def test_a_value_of_no_use_is_reported_and_refused(
    cross, recorded, replay, arguments, tmp_path, capsys, group, values, sentence
):
    scene = cross.surveyed(cross.SCENES["nose33_down45"])

    def spoilt(topic, kind, fields):
        ours = {"gimbal": "gimbal", "height": "altitude", "fix": "gps"}[group] in topic
        return topic, kind, fields | values if ours else fields

    bag = recorded("anafi", scene, change=spoilt)
    assert replay(bag, tmp_path / "out", "--vehicle", "anafi", *arguments) == 0
    assert sentence in capsys.readouterr().err
    rejected = (tmp_path / "out" / "rejected.csv").read_text().splitlines()[1:]
    assert [row.split(",")[1] for row in rejected[:5]] == [f"bad_{group}"] * 5


def test_heights_from_an_altitude_of_nan_are_reported_and_refused(
    cross, recorded, replay, arguments, tmp_path, capsys
):
    scene = cross.surveyed(cross.SCENES["nose33_down45"])

    def blind(topic, kind, fields):
        return topic, kind, fields | {"altitude": math.nan} if "altitude" in fields else fields

    bag = recorded("generic", scene, change=blind)
    own = tmp_path / "own.yaml"
    own.write_text(
        "/**/estimator: {ros__parameters: {height: {source: none}, surface: {altitude: 0.0}, "
        "fix: {altitude_datum: amsl}}}\n"
    )
    assert replay(bag, tmp_path / "out", "--params", own, *arguments) == 0
    assert "The fix's altitude is NaN, but height.source none computes" in capsys.readouterr().err
    assert (tmp_path / "out" / "rejected.csv").read_text().count(",bad_fix,") == 5
