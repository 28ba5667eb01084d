# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator's parameters as the design fixes them, and keys that contradict one another."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.core.values.errors import ConfigError


def test_defaults_are_the_designs():
    config = estimator_config({})
    assert repr(config) == repr(EstimatorConfig())  # NaN is not equal to itself
    assert (config.method, config.max_wait) == ("filter", 3.0)
    assert (config.gimbal.reference, config.gimbal.type) == ("earth", "quaternion")
    assert (config.attitude.type, config.attitude.north) == ("imu", "true")
    assert (config.fix.altitude_datum, config.height.type) == ("unknown", "float64")
    assert (config.height.reference, config.water_level.value_m) == ("water", 0.0)
    topics = [leaf.default for leaf in leaves(EstimatorConfig) if leaf.name.endswith(".topic")]
    assert sorted(topics) == [
        "attitude", "camera/camera_info", "detections", "fix", "gimbal", "height", "water_level",
    ]  # fmt: skip


def test_every_parameter_says_what_it_means_and_its_default_is_allowed():
    for leaf in leaves(EstimatorConfig):
        assert leaf.key.doc.endswith("."), leaf.name
        if leaf.default is not None and leaf.default == leaf.default:  # not NaN
            estimator_config({leaf.name: leaf.default})


def test_noise_sets_are_the_designs_and_single_values_replace_theirs():
    consumer, rtk = Noise(), Noise(set="rtk")
    expected = {
        "gnss_offset_m": (1.2, 0.02), "gnss_white_m": (0.03, 0.03), "heading_deg": (1.5, 0.3),
        "gimbal_pitch_deg": (0.4, 0.15), "gimbal_roll_deg": (0.4, 0.15), "height_m": (0.3, 0.05),
        "correlation_time_s": (300.0, 300.0), "latency_s": (0.0, 0.0),
        "attitude_white_deg": (0.1, 0.1),
        "gimbal_white_deg": (0.03, 0.03), "height_white_m": (0.03, 0.03),
        "box_center_px": (2.0, 2.0), "robot_acceleration": (0.05, 0.05),
    }  # fmt: skip
    names = [leaf.name for leaf in leaves(Noise) if leaf.name != "set"]
    assert sorted(expected) == sorted(names)
    assert {name: (consumer.value(name), rtk.value(name)) for name in names} == expected
    mixed = estimator_config({"noise.set": "rtk", "noise.heading_deg": 2.0}).noise
    assert (mixed.value("heading_deg"), mixed.value("height_m")) == (2.0, 0.05)


@pytest.mark.parametrize(
    ("values", "needed"),
    [
        ({}, False),
        ({"gimbal.reference": "heading"}, True),
        ({"gimbal.reference": "body"}, True),
        ({"gimbal.reference": "fixed"}, True),
        ({"camera.offset_m": [0.1, 0.0, -0.2]}, True),
        ({"height.along": "body"}, True),
    ],
)
def test_attitude_is_needed_for_its_references_and_a_lever_arm(values, needed):
    assert estimator_config(values).needs_attitude == needed


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"camera.source": "parameters"}, r"camera\.focal_length_mm"),
        ({"fix.source": "constant"}, r"fix\.latitude_deg"),
        (
            {"gimbal.source": "constant", "gimbal.rpy_deg": [0.0, math.nan, 0.0]},
            r"gimbal\.rpy_deg must be given",
        ),
        ({"height.source": "constant"}, r"height\.value_m must be given"),
        ({"height.stamp": "header"}, "carry no stamp"),
        ({"gimbal.stamp": "px4_us"}, "quaternion messages do not carry; use header or arrival"),
        ({"attitude.type": "px4_attitude"}, "attitude.stamp is header, which px4_attitude"),
        (
            {"attitude.type": "px4_attitude", "attitude.stamp": "px4_us"},
            "set attitude.world: ned and attitude.body: frd",
        ),
        ({"gimbal.type": "psdk_gimbal", "gimbal.body": "frd"}, "set gimbal.world: enu"),
        ({"gimbal.reference": "mavlink_flags"}, "quaternion messages carry no flags"),
        (
            {"fix.type": "px4_global_position", "fix.stamp": "px4_us"},
            "set fix.altitude_datum to ellipsoid or amsl",
        ),
        ({"height.source": "none"}, r"surface\.altitude must be given"),
        ({"height.source": "none", "surface.altitude": 0.0}, r"fix\.altitude_datum"),
        ({"map.latitude_deg": 13.0}, "given together"),
        (
            {"map.latitude_deg": 13.0, "map.longitude_deg": 5.0}
            | {"fix.source": "constant", "fix.latitude_deg": 15.0, "fix.longitude_deg": 5.0},
            r"The origin of map \(13, 5\) is 221 km from the camera",
        ),
        (
            {"robots.a.class": "b", "robots.a.start": [1, 2], "detections.classes": ["c"]},
            r"robots\.a\.class is 'b', which detections\.classes \(c\) refuses",
        ),
        ({"gimbal": {"refrence": "body"}}, r"did you mean gimbal\.reference\?"),
        ({"camera.latency_s": 3.5}, "within -3 to 3"),
    ],
)
def test_keys_that_contradict_one_another_are_refused(values, words):
    with pytest.raises(ConfigError, match=words):
        estimator_config(values)


@pytest.mark.parametrize("name", ["robots", "classes", "references"])
def test_a_group_of_names_is_no_single_value(name):
    with pytest.raises(ConfigError, match=f"{name} must hold names with their keys, not 'pier'"):
        estimator_config({name: "pier"})
    assert estimator_config({name: None}) == estimator_config({name: {}})


def test_height_from_the_fix_needs_both_altitudes_in_one_datum():
    config = estimator_config(
        {"height.source": "none", "surface.altitude": 1.5, "fix.altitude_datum": "amsl"}
    )
    assert config.surface.altitude == 1.5


@pytest.mark.parametrize(
    "values",
    [
        {"x" * 5000: 1},
        {"robots": {"x" * 5000: 1}},
        {"robots": {"X" * 5000: {"class": "aqua"}}},
        {"robots": {"x" * 5000: {"class": 1}}},
        {"robots": {"a": {"class": ["x"] * 5000}}},
        {"robots": {"a": {"class": "aqua", "start": ["x" * 5000]}}},
        {"robots": {"a": {"class": "aqua", "start": [10**300, 1]}}},
        {"robots": {"a": {"class": "x" * 5000, "start": [1, 2]}}, "detections.classes": ["c"]},
    ],
    ids=range(8),
)
def test_a_refusal_is_one_sentence_however_long_the_value_is(values):
    with pytest.raises(ConfigError) as refusal:
        estimator_config(values)
    assert len(str(refusal.value)) < 500
