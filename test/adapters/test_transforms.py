# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transforms that lead to the robots' true places."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.transforms import course_transforms, earth_transform
from aerial_gnss_ros.core.geometry.geodesy import ecef_from_geodetic
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.values.estimates import State

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import DATUM, LATITUDE, LONGITUDE, RESULT, ROBOT


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
