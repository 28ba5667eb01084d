# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots whose boxes could not correct them begin anew where these are."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.linearization import CameraView, relinearize
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.reinitialization import reinitialize_lost
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.platform_model import COUNT

sys.path.insert(0, str(Path(__file__).parent))

from three_robots import CAMERA, MODEL, PLACES, crowd, sight


def robot(place, sigma_m, speed=1.0):
    """Return a state of one robot."""
    joint = JointState(MODEL.stationary(None))
    wide = sigma_m**2 * np.eye(2)[None]
    joint.add(np.arange(1), np.array([place]), np.zeros((1, 2, COUNT)), wide, speed)
    return joint


@pytest.mark.parametrize(
    ("place", "sigma_m"),
    [
        ((240.0, -1700.0), 1000.0),
        ((-160.0, 1900.0), 900.0),
        ((0.0, 1e5), 1e4),
        ((0.0, 120.0), 60.0),
    ],
    ids=["behind", "far away", "on the horizon", "uncertain by twice its distance"],
)
def test_a_robot_comes_to_lie_where_its_box_is(place, sigma_m):
    joint, first = robot(place, sigma_m), JointState(MODEL.stationary(None))
    there = PLACES[:1] + np.array([1.0, 2.0])
    pixels = linearise(sight(), np.zeros(COUNT), there).pixels
    assert correct(joint, np.array([0]), pixels, sight(), MODEL).count == 2
    np.testing.assert_allclose(joint.robots[0, :2], there[0], atol=1e-3)
    first.add(np.arange(1), there, np.zeros((1, 2, COUNT)), 1000.0**2 * np.eye(2)[None], 1.0)
    correct(first, np.array([0]), pixels, sight(), MODEL)
    np.testing.assert_allclose(joint.covariance, first.covariance, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(joint.covariance.diagonal()[COUNT + 2 :], 1.0, rtol=1e-6)


def test_others_and_a_robot_that_its_box_can_correct_stay():
    joint = crowd()
    before, covariance = joint.mean.copy(), joint.covariance.copy()
    relinearize(joint, sight())
    slots, pixels = np.arange(2), linearise(sight(), joint.mean[:COUNT], PLACES[:2]).pixels
    every = np.ones(2, bool)
    assert not reinitialize_lost(joint, slots, pixels, every, sight())
    np.testing.assert_array_equal(joint.mean, before)
    assert reinitialize_lost(joint, slots, pixels, np.array([True, False]), sight())
    kept = np.r_[: COUNT + 4, COUNT + 8 : COUNT + 12]
    np.testing.assert_array_equal(joint.mean[kept], before[kept])
    assert joint.covariance[COUNT + 4, COUNT + 4] == 1e6
    np.testing.assert_allclose(
        joint.covariance[np.ix_(kept, kept)], covariance[np.ix_(kept, kept)], rtol=1e-2, atol=1e-3
    )


def test_what_is_uncertain_by_less_than_its_distance_is_corrected():
    """100 m away by a camera 20 m high, give or take 50 m: its velocity is known, too."""
    place = (0.0, 100.0)
    joint = robot(place, 50.0, speed=0.1)
    joint.robots[0, 2] = 0.4
    pixels = linearise(sight(), np.zeros(COUNT), np.array([[5.0, 90.0]])).pixels
    correct(joint, np.array([0]), pixels, sight(), MODEL)
    assert joint.robots[0, 2] == pytest.approx(0.4, abs=0.05)


def test_a_box_above_the_horizon_puts_no_robot_anywhere():
    level = MapPose(np.array([0.0, 0.0, 30.0]), matrix_from_rpy(0.0, 0.05, np.pi / 2))
    joint, view = robot((0.0, -50.0), 10.0), CameraView.of(CAMERA, level, np.zeros(6), 0.0)
    outcome = correct(joint, np.array([0]), np.array([[600.0, 10.0]]), view, MODEL)
    assert outcome.count == 0
    np.testing.assert_array_equal(joint.robots[0, :2], [0.0, -50.0])
    assert joint.covariance[COUNT, COUNT] == 100.0
