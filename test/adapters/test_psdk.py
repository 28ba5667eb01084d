# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The gimbal as psdk_ros2 gives it."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.adapters import psdk
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.telemetry.validity import validate

FLU = GimbalConfig(world="enu", body="flu")


def message(roll, pitch, yaw):
    return SimpleNamespace(vector=SimpleNamespace(x=roll, y=pitch, z=yaw))


@pytest.mark.parametrize(
    ("yaw", "ahead"),
    [(1.571, [0.0, 1.0, 0.0]), (1.571 - 0.5 * math.pi, [1.0, 0.0, 0.0])],
    ids=["north", "east"],
)
def test_its_yaw_counts_from_1_571_rad_where_half_a_turn_halved_is_meant(yaw, ahead):
    found = psdk.gimbal(message(0.0, 0.0, yaw), 7, FLU)
    assert found.stamp_ns == 7
    assert matrix_from_quaternion(found.quaternion)[:, 0] == pytest.approx(ahead, abs=1e-12)


def test_a_positive_pitch_looks_down_and_a_positive_roll_lowers_the_right_side():
    found = matrix_from_quaternion(
        psdk.gimbal(message(0.1, math.pi / 6, psdk.NORTH_TO_EAST), 7, FLU).quaternion
    )
    assert found[2, 0] == pytest.approx(-0.5)
    assert found[2, 1] > 0.0  # of the left side


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("angle", "given"), [(6281.0, True), (6286.0, False), (math.nan, False)])
def test_an_angle_beyond_a_thousand_turns_is_none(axis, angle, given):
    angles = [0.0, 0.0, 0.0]
    angles[axis] = angle
    trouble, kept = validate(psdk.gimbal(message(*angles), 7, FLU))
    assert (trouble == "") is given
    assert np.isfinite(kept.quaternion).all() == given
