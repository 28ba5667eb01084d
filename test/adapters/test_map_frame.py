# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of frames, z = 0 on the water, and transforms that lead to the robots' true places."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from aerial_gnss_ros.adapters.map_frame import WAVES_M2, Frames, OnWater, frames
from aerial_gnss_ros.adapters.results import geo_pose, map_datum, markers, nav_sat_fix, odometry
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.processing import MapConfig
from aerial_gnss_ros.core.values.errors import ConfigError

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import DATUM, POSE, RESULT, ROBOT


def test_each_namespace_has_frames_of_its_own_and_a_name_that_is_given_stays():
    assert frames(MapConfig()) == Frames("map", "")
    assert frames(MapConfig(), "/drone1/") == Frames("drone1/map", "drone1/")
    assert frames(MapConfig(frame="pool"), "drone1") == Frames("pool", "drone1/")
    assert not frames(MapConfig(altitude_m=-40.0)).on_water


@pytest.mark.parametrize("name", ["/map", "map/", "a//b", "a b"])
def test_a_frame_with_a_slash_too_many_is_refused(name):
    with pytest.raises(ConfigError, match=r"map.frame .* cannot be a frame: use letters"):
        estimator_config({"map.frame": name})


def test_every_message_names_the_frames():
    own = Frames("drone1/map", "drone1/")
    assert geo_pose(ROBOT, own)["header"]["frame_id"] == "drone1/map"
    assert nav_sat_fix(ROBOT, own)["header"]["frame_id"] == "drone1/aqua_1/course"
    assert odometry(ROBOT, DATUM, own)["header"]["frame_id"] == "drone1/map"
    assert odometry(ROBOT, DATUM, own)["child_frame_id"] == "drone1/aqua_1/course"
    assert map_datum(1, DATUM, own).fields["header"]["frame_id"] == "drone1/map"
    assert markers(RESULT, own).fields["markers"][1]["header"]["frame_id"] == "drone1/map"


def test_z_is_0_on_the_water_whose_altitude_is_that_of_the_origin():
    on_water = OnWater(Frames())
    assert on_water.leveled(replace(RESULT, pose=None)).datum is None  # not known yet
    first = on_water.leveled(RESULT).datum
    assert first.altitude == pytest.approx(-42.0)
    drifted = replace(RESULT, pose=replace(POSE, altitude=-17.0))
    assert on_water.leveled(drifted).datum == first
    fields = odometry(ROBOT, first)
    assert fields["pose"]["pose"]["position"]["z"] == 0.0
    assert fields["pose"]["covariance"][14] == WAVES_M2


def test_a_later_pose_with_an_altitude_is_taken_where_the_first_had_none():
    on_water = OnWater(Frames())
    unknown = replace(RESULT, pose=replace(POSE, altitude=math.nan))
    assert math.isnan(on_water.leveled(unknown).datum.altitude)
    assert on_water.leveled(RESULT).datum.altitude == pytest.approx(-42.0)
    moved = replace(unknown, datum=replace(DATUM, latitude=0.1))
    assert math.isnan(on_water.leveled(moved).datum.altitude)


def test_z_is_above_an_altitude_that_is_given():
    own = frames(MapConfig(altitude_m=-50.0))
    result = OnWater(own).leveled(replace(RESULT, datum=replace(DATUM, altitude=-50.0)))
    assert result.datum.altitude == -50.0
    assert odometry(ROBOT, result.datum, own)["pose"]["pose"]["position"]["z"] == 8.0
