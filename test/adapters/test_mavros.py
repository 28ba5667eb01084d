# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""MAVROS's gimbal topics: MAVLink's axes and signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.adapters import mavros
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion

DOWN_30 = SimpleNamespace(x=0.0, y=-math.sin(math.pi / 12), z=0.0, w=math.cos(math.pi / 12))
CONFIG = GimbalConfig(reference="mavlink_flags", world="ned", body="frd")
YAW_LOCK = 16


def ahead(orientation):
    return matrix_from_quaternion(orientation.quaternion)[:, 0]


@pytest.mark.parametrize(
    ("flags", "reference", "level"), [(YAW_LOCK, "earth", [0.0, 1.0]), (0, "heading", [1.0, 0.0])]
)
def test_flags_say_whether_yaw_counts_from_north_or_from_the_nose(flags, reference, level):
    found = mavros.gimbal(SimpleNamespace(q=DOWN_30, flags=flags), 7, CONFIG)
    assert (found.stamp_ns, found.reference) == (7, reference)
    along = math.cos(math.pi / 6)
    assert ahead(found) == pytest.approx([along * level[0], along * level[1], -0.5], abs=1e-12)


def test_a_mount_looks_down_where_its_pitch_is_negative():
    config = GimbalConfig(reference="heading", world="ned", body="frd")
    found = mavros.mount(DOWN_30, 7, config)
    assert ahead(found) == pytest.approx([math.cos(math.pi / 6), 0.0, -0.5], abs=1e-12)
