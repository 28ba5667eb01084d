# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of drones are parts of topics, and no two are the same."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.fleet import fleet_config
from aerial_gnss_ros.core.values.errors import ConfigError


@pytest.mark.parametrize("name", ["", "drone1", "a", "north_drone", "x" * 64])
def test_a_drone_may_have_a_name(name):
    assert estimator_config({"sightings.drone": name}).sightings.drone == name


@pytest.mark.parametrize("name", ["Drone", "1", "a b", "a__b", "a_", "ä", "a/b", "x" * 65])
def test_a_name_that_no_topic_can_have_is_refused(name):
    with pytest.raises(ConfigError, match="cannot be a drone's name"):
        estimator_config({"sightings.drone": name})


def test_a_fleet_has_drones_each_of_them_once():
    config = fleet_config({"drones": ["drone1", "/north/drone2"], "gnss_share": 0.2})
    assert config.drones == ("drone1", "/north/drone2")
    assert config.gnss_share == 0.2
    with pytest.raises(ConfigError, match="one namespace twice: a, b, a"):
        fleet_config({"drones": ["a", "b", "/a/"]})
    with pytest.raises(ConfigError, match="must be namespaces"):
        fleet_config({"drones": ["a", "/"]})
    with pytest.raises(ConfigError, match="gnss_share"):
        fleet_config({"gnss_share": 1.5})
