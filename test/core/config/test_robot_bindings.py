# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names that are bound to robots by where they start."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.robot_bindings import RobotBinding
from aerial_gnss_ros.core.values.errors import ConfigError


def test_robots_are_bound_to_their_starts_in_order_of_name():
    config = estimator_config(
        {
            "robots": {
                "leader": {"class": "aqua", "start": [13.19, -59.64]},
                "blue_2": {"class": "boat", "start": [13, -59]},
            }
        }
    )
    assert config.robots == (
        RobotBinding("blue_2", "boat", math.radians(13.0), math.radians(-59.0)),
        RobotBinding("leader", "aqua", math.radians(13.19), math.radians(-59.64)),
    )


@pytest.mark.parametrize("start", [[90, 180], [-90, -180], [90.0, -180.0]])
def test_a_start_may_be_anywhere_on_earth(start):
    (robot,) = estimator_config({"robots.a.class": "aqua", "robots.a.start": start}).robots
    assert [math.degrees(robot.latitude), math.degrees(robot.longitude)] == pytest.approx(start)


@pytest.mark.parametrize("start", [[90.1, 0], [-90.1, 0], [0, 180.1], [0, -180.1], [math.nan, 0]])
def test_a_start_that_is_no_place_is_refused(start):
    with pytest.raises(ConfigError, match="not on Earth"):
        estimator_config({"robots.a.class": "aqua", "robots.a.start": start})


@pytest.mark.parametrize(
    ("name", "robot", "words"),
    [
        ("leader", {"colour": "red"}, r"robots\.leader\.colour is not a parameter"),
        ("Leader", {"class": "a", "start": [1, 2]}, "cannot be a topic name"),
        ("2nd", {"class": "a", "start": [1, 2]}, "cannot be a topic name"),
        ("a__b", {"class": "a", "start": [1, 2]}, "cannot be a topic name"),
        ("a", {"start": [1, 2]}, r"robots\.a\.class must be"),
        ("a", {"class": "", "start": [1, 2]}, r"robots\.a\.class must be"),
        ("a", {"class": "b"}, r"\[latitude, longitude\]"),
        ("a", {"class": "b", "start": [1]}, r"\[latitude, longitude\]"),
        ("a", {"class": "b", "start": "12"}, r"\[latitude, longitude\]"),
        ("a", {"class": "b", "start": [True, 2]}, r"\[latitude, longitude\]"),
    ],
)
def test_a_binding_that_cannot_be_is_refused(name, robot, words):
    with pytest.raises(ConfigError, match=words):
        estimator_config({"robots": {name: robot}})
