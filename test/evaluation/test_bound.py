# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The bound of a flight, with and without a robot whose place is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.evaluation.bound import TrueDrone, TrueFrame, bound, joint_bound

CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [], [900.0, 0, 640.0, 0, 900.0, 360.0, 0, 0, 1.0]
)
LOCAL = LocalMap(MapDatum(0.23, -1.04, 0.0))
PLACES = np.array([[0.0, 18.0], [3.0, 20.0]])


def sigmas(known=None, seconds=5):
    """Return one sigma of both robots at the end of a hover, each a mean of both axes, m."""
    rotation = matrix_from_rpy(0.0, math.radians(60.0), math.radians(90.0))
    frames = [
        TrueFrame(
            CameraPose(round(t * 1e8), 0.23, -1.04, 30.0, 30.0, rotation),
            PLACES, np.array([True, True]),
        )
        for t in range(10 * seconds)
    ]  # fmt: skip
    limits = bound(estimator_config({}), CAMERA, frames, LOCAL, known)
    return np.sqrt(np.trace(limits[-1, :, :2, :2], axis1=1, axis2=2) / 2.0)


def test_the_receiver_s_offset_is_in_the_bound_and_a_known_place_takes_it_out():
    free, known = sigmas(), sigmas({0: 0.05})
    assert (free > 1.2).all()
    assert known[0] < 0.05
    assert 0.05 < known[1] < 0.3


def test_a_poorly_known_place_informs_less():
    sigma_m = [sigmas({0: sigma})[1] for sigma in (0.05, 0.5, 1.0, 100.0)]
    assert sigma_m == sorted(sigma_m)
    assert sigma_m[2] == pytest.approx(math.hypot(1.0 / math.hypot(1.0, 1.0 / 1.2), 0.1), rel=0.25)
    assert sigma_m[3] == pytest.approx(sigmas()[1], rel=0.02)


def hovering(bearing, noise="rtk", count=300, height=15.0):
    """A drone that hovers 10 m beside the robots and looks at them, for `joint_bound`."""
    direction = math.radians(bearing)
    away = np.array([[-10.0 * math.cos(direction), -10.0 * math.sin(direction)]])
    latitude, longitude = (float(angle[0]) for angle in LOCAL.places(away))
    rotation = matrix_from_rpy(0.0, math.atan2(height, 10.0), direction)
    places = 0.15 * height * np.array([[0.6, 0.5], [-1.0, 0.2], [0.4, -0.8]])
    frames = [
        TrueFrame(
            CameraPose(round(i * 1e8), latitude, longitude, height, height, rotation),
            places, np.ones(3, np.bool_),
        )
        for i in range(count)
    ]  # fmt: skip
    settings = {"noise.set": noise, "noise.robot_acceleration": 0.001, "tracks.max_speed": 0.01}
    return TrueDrone(estimator_config(settings), CAMERA, frames)


def last(limits):
    """RMS over robots of one sigma at the end, both axes, m."""
    return math.sqrt(float(np.trace(limits[-1, :, :2, :2], axis1=1, axis2=2).mean()))


def test_a_second_drone_on_the_other_side_gives_a_hover_what_it_lacks():
    alone = last(bound(hovering(0.0).config, CAMERA, hovering(0.0).frames, LOCAL))
    two = last(joint_bound([hovering(0.0), hovering(180.0)], LOCAL, 0.0)[0])
    same_side = last(joint_bound([hovering(0.0), hovering(5.0)], LOCAL, 0.0)[0])
    assert two < alone / 2.5
    assert two < same_side < alone


def test_what_receivers_share_no_number_of_drones_can_average():
    drones = [hovering(angle, "consumer", 20) for angle in (0.0, 120.0, 240.0)]
    own, half, shared = (last(joint_bound(drones, LOCAL, share)[1]) for share in (0.0, 0.5, 1.0))
    offset = math.sqrt(2.0) * 1.2
    assert own == pytest.approx(offset / math.sqrt(3.0), rel=0.1)
    assert half == pytest.approx(offset * math.sqrt(2.0 / 3.0), rel=0.1)
    assert shared == pytest.approx(offset, rel=0.1)


def test_a_drone_with_rtk_carries_one_without():
    found = joint_bound([hovering(0.0, "consumer", 50), hovering(180.0, "rtk", 50)], LOCAL, 0.5)
    alone = bound(hovering(0.0, "consumer", 50).config, CAMERA, hovering(0.0).frames[:50], LOCAL)
    assert last(alone) > 1.6
    assert last(found[0]) < 0.25


def test_a_drone_that_shares_no_robot_tells_only_how_the_common_offset_drifts():
    one, other = hovering(0.0, "consumer", 20), hovering(180.0, "consumer", 20)
    blind = np.array([True, False, False]), np.array([False, True, True])
    one, other = (
        TrueDrone(d.config, d.camera, [TrueFrame(f.pose, f.positions, seen) for f in d.frames])
        for d, seen in zip((one, other), blind, strict=True)
    )
    alone = bound(one.config, CAMERA, one.frames, LOCAL)
    apart, common = (joint_bound([one, other], LOCAL, share)[0][-1, 0] for share in (0.0, 1.0))
    np.testing.assert_allclose(apart, alone[-1, 0], rtol=1e-9)
    assert 0.999 < common[0, 0] / alone[-1, 0, 0, 0] < 1.0
    assert np.isnan(alone[-1, 1]).all()
