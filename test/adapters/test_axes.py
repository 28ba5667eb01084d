# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Orientations in the axes that the configuration names."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.adapters import axes
from aerial_gnss_ros.core.config.telemetry import AttitudeConfig, GimbalConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion

TURN = math.radians(30.0)


def ahead(orientation):
    """Return the axis (3,) ahead of a body FLU."""
    return matrix_from_quaternion(orientation.quaternion)[:, 0]


@pytest.mark.parametrize(
    ("world", "body", "yaw", "pitch", "expected"),
    [
        ("enu", "flu", 0.0, 0.0, [1.0, 0.0, 0.0]),  # no angle is east
        ("enu", "flu", TURN, 0.0, [math.cos(TURN), 0.5, 0.0]),  # to the left
        ("enu", "flu", 0.0, TURN, [math.cos(TURN), 0.0, -0.5]),  # nose down
        ("ned", "frd", 0.0, 0.0, [0.0, 1.0, 0.0]),  # no angle is north
        ("ned", "frd", TURN, 0.0, [0.5, math.cos(TURN), 0.0]),  # to the right
        ("ned", "frd", 0.0, TURN, [0.0, math.cos(TURN), 0.5]),  # nose up
    ],
)
def test_a_body_is_given_in_its_own_axes_and_the_worlds(world, body, yaw, pitch, expected):
    quaternion = axes.from_angles(0.0, pitch, yaw)
    found = axes.body(quaternion, 7, AttitudeConfig(world=world, body=body))
    assert found.stamp_ns == 7
    assert ahead(found) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("reference", "reported", "expected", "own"),
    [
        ("earth", "", [0.0, 1.0, 0.0], ""),
        ("earth", "heading", [0.0, 1.0, 0.0], ""),  # the configuration decides
        ("heading", "", [1.0, 0.0, 0.0], ""),
        ("mavlink_flags", "earth", [0.0, 1.0, 0.0], "earth"),
        ("mavlink_flags", "heading", [1.0, 0.0, 0.0], "heading"),
    ],
)
def test_a_camera_is_relative_to_what_configuration_or_message_say(
    reference, reported, expected, own
):
    """Identity in NED and FRD: ahead is north, or the vehicle's nose."""
    config = GimbalConfig(reference=reference, world="ned", body="frd")
    found = axes.camera(np.array([0.0, 0.0, 0.0, 1.0]), 7, config, reported)
    assert ahead(found) == pytest.approx(expected, abs=1e-12)
    assert found.reference == own


@pytest.mark.parametrize(
    ("angle", "valid"),
    [(axes.MOST_RAD, True), (-axes.MOST_RAD, True), (1.001 * axes.MOST_RAD, False),
     (math.inf, False), (math.nan, False)],
)  # fmt: skip
def test_angles_that_are_none_make_no_rotation(angle, valid):
    for angles in ((angle, 0.0, 0.0), (0.0, angle, 0.0), (0.0, 0.0, angle)):
        assert np.isfinite(axes.from_angles(*angles)).all() == valid
