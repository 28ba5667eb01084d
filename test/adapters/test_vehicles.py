# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Each profile against the tables of what vehicles publish: topics, types, QoS, axes, datums."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names, vehicle_summary
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config

SCHEMAS = {"detector": DetectorConfig, "estimator": EstimatorConfig}
MAST = {
    "fix.latitude_deg": 13.0,
    "fix.longitude_deg": -59.0,
    "gimbal.rpy_deg": [0.0, 40.0, 10.0],
    "height.value_m": 9.0,
}

# topic, type, and what its publisher offers: b(est effort), r(eliable), l(atched)
NAVSATFIX, IMU = "sensor_msgs/msg/NavSatFix", "sensor_msgs/msg/Imu"
FLOAT64, FLOAT32 = "std_msgs/msg/Float64", "std_msgs/msg/Float32"
QUATERNION = "geometry_msgs/msg/QuaternionStamped"
GEO_POSE = "geographic_msgs/msg/GeoPoseStamped"
MAVROS = {
    "fix": ("mavros/global_position/global", NAVSATFIX, "b"),
    "attitude": ("mavros/imu/data", IMU, "b"),
    "gimbal": (
        "mavros/gimbal_control/device/attitude_status",
        "mavros_msgs/msg/GimbalDeviceAttitudeStatus",
        "r",
    ),
    "height": ("mavros/global_position/rel_alt", FLOAT64, "b"),
}
TABLES = {
    "mavros_px4": MAVROS,
    "mavros_ardupilot": MAVROS,
    "px4_uxrce": {
        "fix": ("fmu/out/vehicle_global_position", "px4_msgs/msg/VehicleGlobalPosition", "b"),
        "attitude": ("fmu/out/vehicle_attitude", "px4_msgs/msg/VehicleAttitude", "b"),
        "gimbal": (
            "fmu/out/gimbal_device_attitude_status",
            "px4_msgs/msg/GimbalDeviceAttitudeStatus",
            "b",
        ),
        "height": ("fmu/out/vehicle_local_position", "px4_msgs/msg/VehicleLocalPosition", "b"),
    },
    "ardupilot_dds": {
        "fix": ("ap/geopose/filtered", GEO_POSE, "b"),
        "attitude": ("ap/geopose/filtered", GEO_POSE, "b"),
        "height": ("ap/pose/filtered", "geometry_msgs/msg/PoseStamped", "b"),
    },
    "dji_psdk": {
        "fix": ("wrapper/psdk_ros2/gps_position_fused", NAVSATFIX, "r"),
        "attitude": ("wrapper/psdk_ros2/attitude", QUATERNION, "r"),
        "gimbal": ("wrapper/psdk_ros2/gimbal_angles", "geometry_msgs/msg/Vector3Stamped", "r"),
        "height": ("wrapper/psdk_ros2/altitude_sea_level", FLOAT32, "r"),
        "home": ("wrapper/psdk_ros2/home_point_altitude", FLOAT32, "r"),
    },
    "anafi": {
        "fix": ("anafi/drone/gps/location", NAVSATFIX, "b"),
        "attitude": ("anafi/drone/attitude", QUATERNION, "b"),
        "gimbal": ("anafi/gimbal/attitude", QUATERNION, "b"),
        "height": ("anafi/drone/altitude_above_to", FLOAT32, "b"),
    },
    "generic": {
        "fix": ("fix", NAVSATFIX, "b"),
        "attitude": ("attitude", IMU, "b"),
        "gimbal": ("gimbal", QUATERNION, "b"),
        "height": ("height", FLOAT64, "r"),
    },
    "fixed_camera": {},
}
# altitude_datum; attitude world, body; gimbal reference, world, body; clocks of these inputs
CONVENTIONS = {
    "mavros_px4": ("ellipsoid", "enu flu", "mavlink_flags ned frd", "header header header arrival"),
    "mavros_ardupilot": (
        "ellipsoid",
        "enu flu",
        "mavlink_flags ned frd",
        "header header header arrival",
    ),
    "px4_uxrce": ("ellipsoid", "ned frd", "mavlink_flags ned frd", "px4_us px4_us px4_us px4_us"),
    "ardupilot_dds": ("amsl", "enu flu", "fixed enu flu", "header header header header"),
    "dji_psdk": ("ellipsoid", "enu flu", "earth enu flu", "header header header arrival"),
    "anafi": ("unknown", "nwu flu", "earth nwu flu", "arrival arrival arrival arrival"),
    "generic": ("unknown", "enu flu", "earth enu flu", "header header header arrival"),
    "fixed_camera": ("ellipsoid", "enu flu", "earth enu flu", "header header header arrival"),
}


def values_of(name):
    values = read([vehicle_file(name)], SCHEMAS)
    return values["detector"], values["estimator"] | (MAST if name == "fixed_camera" else {})


def subscriptions(name):
    found = Feed(estimator_config(values_of(name)[1]), object()).subscriptions
    return {s.name: s for s in found}


@pytest.mark.parametrize("name", vehicle_names())
def test_topics_and_types_are_the_tables(name):
    found = {
        key: (s.topic, s.msgtype)
        for key, s in subscriptions(name).items()
        if key not in ("detections", "camera_info", "water_level")
    }
    expected = {key: row[:2] for key, row in TABLES[name].items()}
    if name == "fixed_camera":  # subscribed to, but nothing needs it
        assert not subscriptions(name)["attitude"].required
        del found["attitude"]
    assert found == expected


@pytest.mark.parametrize("name", vehicle_names())
def test_axes_references_datums_and_clocks_are_the_tables(name):
    config = estimator_config(values_of(name)[1])
    attitude, gimbal = config.attitude, config.gimbal
    inputs = (config.fix, attitude, gimbal, config.height)
    assert CONVENTIONS[name] == (
        config.fix.altitude_datum,
        f"{attitude.world} {attitude.body}",
        f"{gimbal.reference} {gimbal.world} {gimbal.body}",
        " ".join(group.stamp for group in inputs),
    )
    detector_config(values_of(name)[0])
    assert vehicle_summary(name)


@pytest.mark.parametrize("name", vehicle_names())
def test_every_publishers_quality_of_service_fits(name):
    qos = pytest.importorskip("aerial_gnss_ros.nodes.qos", reason="ROS 2 is not installed")
    from rclpy.qos import QoSCompatibility, qos_check_compatible

    offered = {"b": qos.sensor(5), "r": qos.detections(), "l": qos.latched()}
    depths = {s.name: s.depth for s in subscriptions(name).values()}
    for key, (_, _, letter) in TABLES[name].items():
        asked = qos.sensor(depths[key])
        assert qos_check_compatible(offered[letter], asked)[0] != QoSCompatibility.ERROR
        too_much = qos_check_compatible(offered[letter], qos.detections())[0]
        assert (too_much == QoSCompatibility.ERROR) == (letter == "b")


@pytest.mark.parametrize("name", vehicle_names())
def test_every_topic_moves_with_the_namespace(name):
    detector, estimator = values_of(name)
    topics = [value for key, value in (detector | estimator).items() if key.endswith("topic")]
    assert topics
    assert not [topic for topic in topics if topic.startswith("/")]


def test_only_px4s_topics_have_versions():
    for name in vehicle_names():
        for s in subscriptions(name).values():
            assert s.versioned == s.msgtype.startswith("px4_msgs/"), (name, s.name)


def test_every_type_that_can_be_chosen_can_be_read():
    choices = {leaf.name: set(leaf.key.choices) for leaf in leaves(EstimatorConfig)}
    for group, kinds in (
        ("fix", FIX),
        ("attitude", ATTITUDE),
        ("gimbal", GIMBAL),
        ("height", HEIGHT),
    ):
        assert set(kinds) == choices[f"{group}.type"]


def test_a_mast_must_be_surveyed_before_anything_starts():
    _, values = values_of("fixed_camera")
    for key in MAST:
        blank = [math.nan] * 3 if key == "gimbal.rpy_deg" else math.nan
        with pytest.raises(ConfigError, match=key.replace(".", r"\.")):
            estimator_config(values | {key: blank})


def test_a_profile_that_is_no_text_is_refused(tmp_path, capsys):
    path = tmp_path / "mine.yaml"
    path.write_bytes(b"a: 1\n\xff\xfe")
    assert cli.main(["profiles", str(path)]) == 2
    assert f"{path}: is not text in UTF-8 (line 2)" in capsys.readouterr().err
