# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss doctor`: which profile a bag is of, in which namespace, and what to paste."""

from __future__ import annotations

import copy
import json
import struct

import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.vehicles import vehicle_names
from aerial_gnss_ros.bags.typestore import typestore
from aerial_gnss_ros.commands import doctor as command
from aerial_gnss_ros.nodes.schemas import SCHEMAS

DJI = {
    "camera/camera_info": "sensor_msgs/msg/CameraInfo",
    "wrapper/psdk_ros2/gps_position_fused": "sensor_msgs/msg/NavSatFix",
    "wrapper/psdk_ros2/attitude": "geometry_msgs/msg/QuaternionStamped",
    "wrapper/psdk_ros2/gimbal_angles": "geometry_msgs/msg/Vector3Stamped",
    "wrapper/psdk_ros2/altitude_sea_level": "std_msgs/msg/Float32",
    "wrapper/psdk_ros2/home_point_altitude": "std_msgs/msg/Float32",
    "wrapper/psdk_ros2/main_camera_stream": "sensor_msgs/msg/Image",
}
PX4 = """uint64 timestamp
float32[4] q
"""


def write(path, topics, definitions=None):
    """Write a bag of empty messages, ten a second; a definition of None is not recorded."""
    store = copy.deepcopy(typestore())
    for name, text in (definitions or {}).items():
        if text is not None:
            store.register(get_types_from_msg(text, name))
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        for topic, msgtype in topics.items():
            if definitions and definitions.get(msgtype, "") is None:
                connection = bag.add_connection(topic, msgtype, msgdef="", rihs01="none")
            else:
                connection = bag.add_connection(topic, msgtype, typestore=store)
            for i in range(21):
                bag.write(connection, i * 100_000_000, struct.pack("<4x600x"))
    return path


def doctor(capsys, *args):
    capsys.readouterr()
    status = cli.main(["doctor", *map(str, args)])
    return status, capsys.readouterr().out


def test_a_profile_is_found_in_its_namespace_with_lines_to_paste(tmp_path, capsys):
    bag = write(tmp_path / "bag", {f"/d1/{topic}": kind for topic, kind in DJI.items()})
    status, out = doctor(capsys, bag)
    assert status == 0
    assert "best: dji_psdk, namespace d1" in out
    assert f"aerial-gnss replay {bag} --vehicle dji_psdk --namespace d1 -o result" in out
    assert "vehicle:=dji_psdk namespace:=d1" in out
    assert "for --params" not in out
    assert "10.0 Hz" in out
    found = json.loads(doctor(capsys, bag, "--json")[1])
    assert found["profiles"][0]["complete"]
    assert found["profiles"][0]["matched"]["gimbal"] == "/d1/wrapper/psdk_ros2/gimbal_angles"


def test_what_is_missing_is_proposed_as_parameters_that_can_be_read(tmp_path, capsys):
    topics = {f"/{topic}": kind for topic, kind in DJI.items()}
    height = topics.pop("/wrapper/psdk_ros2/altitude_sea_level")
    topics["/my/height"] = height
    topics["/my/camera/compressed"] = "sensor_msgs/msg/CompressedImage"
    del topics["/wrapper/psdk_ros2/main_camera_stream"]
    topics["/robots/aqua_1/fix"] = "sensor_msgs/msg/NavSatFix"  # a result is no input
    status, out = doctor(capsys, write(tmp_path / "bag", topics))
    assert status == 1
    assert "height: no topic wrapper/psdk_ros2/altitude_sea_level" in out
    assert "/robots" not in out.split("best:")[1]
    text = out.split("among alternatives\n")[1]
    params = tmp_path / "my.yaml"
    params.write_text(text)
    yaml.safe_load(text)
    values = read([params], SCHEMAS, "/")
    assert values["estimator"]["height.topic"] == "/my/height"
    assert values["estimator"]["height.type"] == "float32"
    assert values["detector"] == {"image.topic": "/my/camera", "image.transport": "compressed"}


def test_another_type_is_named_and_versions_of_px4_are_found(tmp_path, capsys):
    topics = {"/fix": "sensor_msgs/msg/NavSatFix", "/gimbal": "geometry_msgs/msg/Vector3Stamped",
              "/height": "std_msgs/msg/Float64", "/attitude": "sensor_msgs/msg/Imu",
              "/camera/camera_info": "sensor_msgs/msg/CameraInfo"}  # fmt: skip
    _, out = doctor(capsys, write(tmp_path / "a", topics))
    assert "best: generic" in out
    assert (
        "gimbal: /gimbal carries geometry_msgs/msg/Vector3Stamped, not geometry_msgs"
        in " ".join(out.split())
    )
    px4 = {"/x1/fmu/out/vehicle_attitude_v2": "px4_msgs/msg/VehicleAttitude"}
    bag = write(tmp_path / "b", px4, {"px4_msgs/msg/VehicleAttitude": PX4})
    found = json.loads(doctor(capsys, bag, "--vehicle", "px4_uxrce", "--json")[1])
    assert found["profiles"][0]["namespace"] == "x1"
    assert found["profiles"][0]["matched"] == {"attitude": "/x1/fmu/out/vehicle_attitude_v2"}


def test_several_drones_are_distinguished(tmp_path, capsys):
    topics = {f"/d1/{topic}": kind for topic, kind in DJI.items()}
    generic = {"fix": "sensor_msgs/msg/NavSatFix", "attitude": "sensor_msgs/msg/Imu",
               "gimbal": "geometry_msgs/msg/QuaternionStamped", "height": "std_msgs/msg/Float64",
               "camera/camera_info": "sensor_msgs/msg/CameraInfo"}  # fmt: skip
    topics |= {f"/d2/{topic}": kind for topic, kind in generic.items()}
    bag = write(
        tmp_path / "bag", topics | {"/pier/camera/camera_info": generic["camera/camera_info"]}
    )
    _, out = doctor(capsys, bag)
    assert "best: dji_psdk, namespace d1" in out
    assert "another drone: --vehicle generic --namespace d2\n" in out
    assert out.count("another drone") == 1
    assert "matches equally well" not in out
    found = json.loads(doctor(capsys, bag, "--json")[1])
    assert found["other_drones"] == [{"profile": "generic", "namespace": "d2"}]


def test_a_camera_that_is_not_described_can_be_given_by_numbers(tmp_path, capsys):
    topics = {f"/{topic}": kind for topic, kind in DJI.items()}
    del topics["/camera/camera_info"]
    _, out = doctor(capsys, write(tmp_path / "bag", topics))
    assert "# source: parameters, with focal_length_mm" in out
    assert "source: constant" not in out


def test_types_that_nobody_knows_are_reported_and_harm_nothing(tmp_path, capsys):
    kinds = {"secret_msgs/msg/Thing": None}
    topics = {"/thing": "secret_msgs/msg/Thing", "/fix": "sensor_msgs/msg/NavSatFix"}
    status, out = doctor(capsys, write(tmp_path / "bag", topics, kinds))
    assert status == 1
    assert "secret_msgs/msg/Thing" in out
    assert "neither the bag nor this program" in " ".join(out.split())


TWINS = {"mavros_px4", "mavros_ardupilot"}  # one driver: names and types are the same


@pytest.mark.parametrize("vehicle", [v for v in vehicle_names() if v != "fixed_camera"])
def test_every_profile_is_proposed_for_its_own_topics(tmp_path, capsys, vehicle):
    topics = {f"/x1/{s.topic}": s.msgtype for s in command._subscriptions(vehicle)}
    shipped = typestore().fielddefs
    foreign = {kind: PX4 for kind in topics.values() if kind not in shipped}
    bag = write(tmp_path / "bag", topics, foreign)
    found = json.loads(doctor(capsys, bag, "--json")[1])["profiles"][0]
    assert found["namespace"] == "x1"
    assert found["complete"]
    assert found["profile"] == vehicle or {found["profile"], vehicle} == TWINS


@pytest.mark.parametrize(
    ("args", "words"),
    [(("absent",), "does not exist"), (("--seconds", "-1"), "--seconds must be above 0"),
     (("bag", "--vehicle", "spaceship"), "not a vehicle profile")],
)  # fmt: skip
def test_wrong_input_is_one_sentence(tmp_path, capsys, monkeypatch, args, words):
    write(tmp_path / "bag", {"/fix": "sensor_msgs/msg/NavSatFix"})
    monkeypatch.chdir(tmp_path)
    assert cli.main(["doctor", *args]) == 2
    sentence = capsys.readouterr().err.strip()
    assert words in sentence
    assert "\n" not in sentence
