# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ArduPilot's own topics."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.adapters import ardupilot
from aerial_gnss_ros.core.config.telemetry import AttitudeConfig, FixConfig, HeightConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion


def pose(position, orientation=(0.0, 0.0, 0.0, 1.0)):
    x, y, z, w = orientation
    q = SimpleNamespace(x=x, y=y, z=z, w=w)
    return SimpleNamespace(pose=SimpleNamespace(position=position, orientation=q))


def test_a_geo_pose_is_a_position_without_covariance():
    at = SimpleNamespace(latitude=45.0, longitude=-90.0, altitude=12.5)
    fix = ardupilot.geo_position(pose(at), 7, FixConfig())
    assert (fix.stamp_ns, fix.altitude, fix.valid, fix.covariance) == (7, 12.5, True, None)
    assert [fix.latitude, fix.longitude] == pytest.approx([math.pi / 4, -math.pi / 2])


def test_the_body_of_a_pose_comes_in_the_configured_axes():
    half = math.sqrt(0.5)
    msg = pose(None, (0.0, 0.0, half, half))  # a quarter turn about z
    for world, body, ahead in (("enu", "flu", [0.0, 1.0, 0.0]), ("ned", "frd", [1.0, 0.0, 0.0])):
        found = ardupilot.pose_orientation(msg, 7, AttitudeConfig(world=world, body=body))
        assert matrix_from_quaternion(found.quaternion)[:, 0] == pytest.approx(ahead, abs=1e-12)


def test_a_height_is_z_of_a_pose():
    height = ardupilot.pose_height(pose(SimpleNamespace(x=1.0, y=2.0, z=3.5)), 7, HeightConfig())
    assert (height.stamp_ns, height.value) == (7, 3.5)
