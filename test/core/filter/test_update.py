# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Update of robots and platform by an image: as the textbook has it, outliers, refusals."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.update import TUNING as UPDATE
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY

sys.path.insert(0, str(Path(__file__).parent))

from three_robots import MODEL, PLACES, crowd, sight


@pytest.mark.parametrize("alone", [False, True])
def test_correction_is_that_of_the_textbook(alone):
    """What is considered, not estimated, has no gain (Schmidt's filter in Joseph's form)."""
    joint = crowd()
    slots = np.array([2, 0])
    linear = linearise(sight(), joint.mean[:COUNT], joint.robots[slots, :2])
    pixels = linear.pixels + np.array([[1.5, -2.0], [0.5, 1.0]])
    H = np.zeros((4, COUNT + 12))
    H[:, :COUNT] = linear.by_platform.reshape(4, COUNT)
    H[:2, COUNT + 8 : COUNT + 10] = linear.by_place[0]
    H[2:, COUNT : COUNT + 2] = linear.by_place[1]
    white = linear.by_pose.reshape(4, 6)
    R = white @ np.diag(MODEL.white) @ white.T + MODEL.pixel * np.eye(4)
    S = H @ joint.covariance @ H.T + R
    K = joint.covariance @ H.T @ np.linalg.inv(S)
    residual = (pixels - linear.pixels).ravel()
    K[LATENCY] = 0.0
    if alone:
        K[:COUNT] = K[COUNT + 4 : COUNT + 8] = (
            0.0  # the platform's errors, and the robot that is not shown
        )
    mean = joint.mean + K @ residual
    left = np.eye(COUNT + 12) - K @ H
    covariance = left @ joint.covariance @ left.T + K @ R @ K.T
    outcome = correct(joint, slots, pixels, sight(), MODEL, alone=alone)
    np.testing.assert_allclose(joint.mean, mean, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(joint.covariance, covariance, rtol=1e-7, atol=1e-10)
    assert outcome.count == 4
    assert outcome.squared == pytest.approx(residual @ np.linalg.inv(S) @ residual)
    np.testing.assert_array_equal(joint.unseen[slots], 0.0)


def test_an_outlier_pulls_no_more_than_at_the_edge_of_what_is_good():
    pulls = []
    for distance in (0.0, 20.0, 1000.0, 10000.0):
        joint = JointState(MODEL.stationary(None))
        joint.add(np.arange(1), PLACES[:1], np.zeros((1, 2, COUNT)), 0.01 * np.eye(2)[None], 0.0)
        pixels = linearise(sight(), np.zeros(COUNT), PLACES[:1]).pixels + np.array([distance, 0.0])
        before = joint.robots[0, :2].copy()
        correct(joint, np.array([0]), pixels, sight(), MODEL)
        pulls.append(float(np.linalg.norm(joint.robots[0, :2] - before)))
    assert pulls[0] == 0.0
    assert 0.0 < pulls[1] < pulls[2] < UPDATE.huber_planar * 0.1
    assert pulls[3] == pytest.approx(pulls[2], rel=0.2)


def _swimmer(speed: float, sigma: float, slot: int) -> tuple[JointState, np.ndarray]:
    """Return two robots, one of which swims East as fast as that, and a pixel where that is."""
    joint = JointState(MODEL.stationary(None))
    own = np.tile(0.01 * np.eye(2), (2, 1, 1))
    joint.add(np.arange(2), PLACES[:2], np.zeros((2, 2, COUNT)), own, sigma)
    joint.mean[COUNT + 2 + 4 * slot] = speed
    return joint, linearise(sight(), np.zeros(COUNT), PLACES[slot : slot + 1]).pixels


@pytest.mark.parametrize(
    ("speed", "sigma", "refused"),
    [
        (1.4, 0.01, False),
        (1.5 + 2.9 * 0.01 * math.sqrt(2.0), 0.01, False),  # within three sigmas of both axes
        (1.5 + 3.1 * 0.01 * math.sqrt(2.0), 0.01, True),
        (2.2, 5.0, False),  # however unsure it is: up to half as fast again
        (2.3, 5.0, True),
    ],
)
@pytest.mark.parametrize("slot", [0, 1])
def test_a_box_by_which_a_robot_is_too_fast_is_not_used(speed, sigma, refused, slot):
    joint, pixels = _swimmer(speed, sigma, slot)
    before = joint.mean.copy(), joint.covariance.copy()
    joint.unseen[:] = 1.0
    outcome = correct(joint, np.array([slot]), pixels, sight(), MODEL, 1.5)
    assert outcome.refused.tolist() == ([slot] if refused else [])
    assert outcome.count == (0 if refused else 2)
    assert joint.unseen[slot] == (1.0 if refused else 0.0)
    if refused:
        np.testing.assert_array_equal(joint.mean, before[0])
        np.testing.assert_array_equal(joint.covariance, before[1])


def test_a_robot_that_the_camera_cannot_see_is_left_out():
    """A pixel outside the image is no evidence; others are corrected as if it were not there."""
    joint, other = crowd(), crowd()
    joint.robots[1, :2] = other.robots[1, :2] = [0.0, -100.0]  # behind the camera
    pixels = linearise(sight(), joint.mean[:COUNT], joint.robots[:1, :2]).pixels + 2.0
    both = correct(joint, np.array([1, 0]), np.vstack([[-5.0, 5.0], pixels]), sight(), MODEL)
    alone = correct(other, np.array([0]), pixels, sight(), MODEL)
    assert (both.count, both.squared) == (2, alone.squared)
    np.testing.assert_array_equal(joint.mean, other.mean)
    nobody = correct(joint, np.array([1]), np.array([[-5.0, 5.0]]), sight(), MODEL)
    assert (nobody.count, nobody.squared) == (0, 0.0)


def test_a_robot_that_was_far_from_where_it_is_seen_comes_to_lie_there():
    """The derivatives where it was expected are not those where it is: the step is repeated."""
    joint = JointState(MODEL.stationary(None) * 1e-12)
    here, wide = np.array([[0.0, 26.0]]), 400.0 * np.eye(2)[None]
    joint.add(np.arange(1), here, np.zeros((1, 2, COUNT)), wide, 1.0)
    there = np.array([[6.0, 40.0]])
    pixels = linearise(sight(), np.zeros(COUNT), there).pixels
    correct(joint, np.array([0]), pixels, sight(), MODEL, level=1e-6)
    np.testing.assert_allclose(joint.robots[0, :2], there[0], atol=0.1)


def test_the_order_of_boxes_does_not_matter():
    joint, other = crowd(), crowd()
    n = len(joint)
    pixels = linearise(sight(), joint.mean[:COUNT], joint.robots[:, :2]).pixels
    pixels += np.arange(2.0 * n).reshape(n, 2)
    correct(joint, np.arange(n), pixels, sight(), MODEL)
    correct(other, np.arange(n)[::-1], pixels[::-1], sight(), MODEL)
    np.testing.assert_allclose(joint.mean, other.mean, atol=1e-9)
    np.testing.assert_allclose(joint.covariance, other.covariance, atol=1e-9)
