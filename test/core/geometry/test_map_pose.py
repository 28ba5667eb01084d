# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera's pose in `map`: where it is, how it stands, and with errors taken out."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import LocalMap, enu_from_geodetic, geodetic_from_enu
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import MapDatum

ORIGIN = (math.radians(48.0), math.radians(11.0))
LOCAL = LocalMap(MapDatum(*ORIGIN, 0.0))
LOOKS = matrix_from_rpy(0.02, math.radians(50.0), 0.7)


def test_a_pose_has_its_place_and_direction_in_the_map():
    """A point 10 m ahead of the camera is where the map says, by way of its geodetic place."""
    latitude, longitude, _ = geodetic_from_enu(700.0, -500.0, 30.0, *ORIGIN, 0.0)
    altitude = 30.0 + (700.0**2 + 500.0**2) / (2.0 * 6.37e6)  # the Earth falls away by 58 mm
    pose = MapPose.of(
        CameraPose(0, float(latitude), float(longitude), altitude, 99.0, LOOKS), LOCAL
    )
    assert pose.position == pytest.approx([700.0, -500.0, 30.0], abs=2e-3)
    ahead = LOOKS @ [10.0, 0.0, 0.0]
    there = geodetic_from_enu(*ahead, float(latitude), float(longitude), altitude)
    expected = enu_from_geodetic(*there, *ORIGIN, 0.0)
    assert pose.position + pose.rotation @ [10.0, 0.0, 0.0] == pytest.approx(expected, abs=1e-6)
    np.testing.assert_allclose(pose.optical, pose.rotation @ FLU_FROM_OPTICAL)


def test_a_change_is_added_to_the_place_and_turns_the_camera_in_map():
    pose = MapPose(np.array([1.0, 2.0, 30.0]), np.eye(3))
    found = pose.corrected(np.array([3.0, -1.0, 0.5, 0.0, 0.0, math.pi / 2.0]))
    assert found.position == pytest.approx([4.0, 1.0, 30.5])
    assert found.rotation @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 1.0, 0.0])  # counterclockwise
    rolled = pose.corrected(np.array([0.0, 0.0, 0.0, 0.0, -math.pi / 2.0, 0.0]))
    assert rolled.rotation @ [0.0, 0.0, 1.0] == pytest.approx([-1.0, 0.0, 0.0])  # about South
