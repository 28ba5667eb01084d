# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters by class: the global ones where there is none, one sentence where one is wrong."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.robot_classes import RobotClass, leaf_of
from aerial_gnss_ros.core.values.errors import ConfigError


def test_a_class_has_what_is_given_of_it_and_the_global_rest():
    config = estimator_config(
        {
            "tracks.max_speed": 2.0,
            "noise.set": "rtk",
            "classes": {
                "aqua": {"max_speed": 1, "coast_s": 30.0, "length_m": [0.4, 0.9]},
                "buoy": {"acceleration": 0.0},
            },
        }
    )
    assert config.robot_class("aqua") == RobotClass(1.0, 0.05, 30.0, (0.4, 0.9))
    assert config.robot_class("buoy") == RobotClass(2.0, 0.0, 120.0)
    assert config.robot_class("boat") == RobotClass(2.0, 0.05, 120.0)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"classes.aqua.max_sped": 1.0}, r"did you mean classes\.aqua\.max_speed\?"),
        (
            {"classes.aqua.max_speed": 60.0},
            r"^classes\.aqua\.max_speed must lie within 0\.01",
        ),
        ({"classes.aqua.max_speed": "fast"}, r"classes\.aqua\.max_speed must be a number \(m/s\)"),
        (
            {"classes.aqua.length_m": [0.9, 0.4]},
            r"length_m must be the shortest and the longest length, .* not \[0\.9, 0\.4\]\.$",
        ),
        ({"classes.aqua.length_m": [0.9]}, r"such as \[0\.4, 0\.9\], not \[0\.9\]\.$"),
        ({"classes.aqua.length_m": [0.0, 1.0]}, r"length_m must lie within 0\.01"),
        (
            {"classes.aqua": 1.0},
            r"^classes\.aqua is not a parameter; classes\.<name> has ",
        ),
        (
            {"classes.aqau.max_speed": 1.0, "detections.classes": ["aqua", "buoy"]},
            r"detections\.classes \(aqua, buoy\); did you mean classes\.aqua\?$",
        ),
        (
            {"classes.ship.max_speed": 1.0, "detections.classes": ["aqua", "buoy"]},
            r"'ship' is not in detections\.classes \(aqua, buoy\); add it there\.$",
        ),
    ],
)
def test_what_is_wrong_with_a_class_is_refused_in_a_sentence(values, sentence):
    with pytest.raises(ConfigError, match=sentence) as refused:
        estimator_config(values)
    assert "\n" not in str(refused.value)


def test_finds_the_meaning_of_a_classs_parameter():
    leaf = leaf_of("classes.aqua.max_speed")
    assert leaf is not None
    assert (leaf.name, leaf.key.unit, leaf.key.high) == ("classes.aqua.max_speed", "m/s", 50.0)
    assert leaf_of("classes.aqua.colour") is None
    assert leaf_of("robots.aqua.max_speed") is None
