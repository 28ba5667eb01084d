# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of frames, z = 0 on the water, and transforms that lead to the robots' true places."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.adapters.map_frame import WAVES_M2, Frames, OnWater, frames
from aerial_gnss_ros.adapters.results import geo_pose, map_datum, markers, nav_sat_fix, odometry
from aerial_gnss_ros.adapters.transforms import course_transforms, earth_transform
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.processing import MapConfig
from aerial_gnss_ros.core.geometry.geodesy import ecef_from_geodetic
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, RobotEstimate, State

LATITUDE, LONGITUDE = math.radians(13.0), math.radians(-59.0)
DATUM = MapDatum(LATITUDE, LONGITUDE, -20.0)  # of the drone's first fix
POSE = CameraPose(1, LATITUDE, LONGITUDE, 22.0, -20.0, np.eye(3))
ROBOT = RobotEstimate(
    stamp_ns=5_000_000_007,
    robot_id="aqua_1",
    class_id="aqua",
    state=State.CONFIRMED,
    latitude=LATITUDE,
    longitude=LONGITUDE,
    altitude=-42.0,
    position=np.array([30.0, 20.0]),
    velocity=np.array([0.0, 2.0]),
    covariance=np.diag([4.0, 9.0, 0.01, 0.04]),
    last_seen_ns=5_000_000_007,
)
RESULT = FrameResult(ROBOT.stamp_ns, "camera", (ROBOT,), (), DATUM, POSE)


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


def rotated(rotation, vector):
    """Return a vector rotated by a quaternion, by the quaternion's own definition."""
    u, w = np.array([rotation["x"], rotation["y"], rotation["z"]]), rotation["w"]
    return vector + 2.0 * np.cross(u, np.cross(u, vector) + w * vector)


def through(transform, point):
    """Return a point given in a transform's child frame in its parent frame."""
    t = transform["transform"]["translation"]
    place = np.array([t["x"], t["y"], t["z"]])
    return place + rotated(transform["transform"]["rotation"], np.asarray(point))


def test_earth_map_course_lead_to_the_robot_s_true_place():
    own = Frames("drone1/map", "drone1/")
    datum = replace(DATUM, altitude=-42.0)
    (course,) = course_transforms(RESULT, own).fields["transforms"]
    (earth,) = earth_transform(1, datum, own).fields["transforms"]
    assert (course["header"]["frame_id"], course["child_frame_id"]) == (
        "drone1/map", "drone1/aqua_1/course",
    )  # fmt: skip
    assert (earth["header"]["frame_id"], earth["child_frame_id"]) == ("earth", "drone1/map")
    assert course["header"]["stamp"] == {"sec": 5, "nanosec": 7}
    # 1 m ahead of a robot on a northward course at (30, 20) is (30, 21): 21 m north is 1.9e-4 deg.
    ahead = through(course, [1.0, 0.0, 0.0])
    np.testing.assert_allclose(ahead, [30.0, 21.0, 0.0], atol=1e-9)
    north, east = 21.0 / 6_337_700.0, 30.0 / (6_379_210.0 * math.cos(LATITUDE))
    true = ecef_from_geodetic(LATITUDE + north, LONGITUDE + east, -42.0).ravel()
    np.testing.assert_allclose(through(earth, ahead), true, atol=2e-3)


def test_lost_robots_have_no_frame_and_an_unknown_altitude_is_sea_level():
    gone = replace(RESULT, estimates=(replace(ROBOT, state=State.LOST),))
    assert course_transforms(gone, Frames()) is None
    unknown = replace(DATUM, altitude=math.nan)
    (earth,) = earth_transform(1, unknown, Frames()).fields["transforms"]
    sea = ecef_from_geodetic(LATITUDE, LONGITUDE, undulation(LATITUDE, LONGITUDE)).ravel()
    np.testing.assert_allclose(through(earth, [0.0, 0.0, 0.0]), sea, atol=1e-6)
