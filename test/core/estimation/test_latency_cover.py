# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What other latencies make of positions is in their covariance."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation.latency_cover import LatencyCover
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State

LATE = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
DOWN = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # optical, looks down


def camera(east, yaw=0.0, up=30.0):
    turned = rotation_matrix(np.array([0.0, 0.0, yaw])) @ DOWN
    return MapPose(np.array([east, 0.0, up]), turned @ FLU_FROM_OPTICAL.T)


def robot(east, north, name="aqua_1"):
    return RobotEstimate(
        0, name, "aqua", State.CONFIRMED, 0.2, -1.0, 0.0, np.array([east, north]), np.zeros(2),
        np.eye(4), 0,
    )  # fmt: skip


def flown(path, until_s=4.0):
    cover = LatencyCover(LATE, 0.1)
    for t in np.arange(0.0, until_s + 0.05, 0.1):
        cover.add(t, path(t))
    return cover


def added(cover, east=3.0, north=4.0):
    (one,) = cover.widened([robot(east, north)])
    np.testing.assert_array_equal(one.covariance[2:], np.eye(4)[2:])
    return one.covariance[:2, :2] - np.eye(2)


def test_a_camera_that_passes_shows_robots_along_its_way():
    """5 m/s, 1 or 2 s: 5 or 10 m off, each way with a probability of 0.025."""
    wider = added(flown(lambda t: camera(5.0 * t)))
    np.testing.assert_allclose(wider, [[0.05 * (25.0 + 100.0), 0.0], [0.0, 0.0]], atol=1e-3)


def test_a_camera_that_turns_shows_robots_around_it():
    """Not to first order: at 1 rad/s a robot 5 m off is on the other side after 2 s."""
    wider = added(flown(lambda t: camera(0.0, t)))
    chords = 2.0 * 5.0 * np.sin([0.5, 1.0])
    assert np.trace(wider) == pytest.approx(0.05 * float(chords @ chords), rel=0.01)


def circling(t):
    """Around a place 20 m ahead, at 0.4 rad/s."""
    turned = rotation_matrix(np.array([0.0, 0.0, 0.4 * t]))
    position = turned @ np.array([-20.0, 0.0, 0.0]) + np.array([0.0, 0.0, 30.0])
    return MapPose(position, turned @ camera(0.0).rotation)


@pytest.mark.parametrize("late_s", [-2.0, 2.0])
def test_a_camera_that_circles_goes_on_around_its_circle(late_s):
    """What stays seems to turn about the middle: the other way where the latency is negative."""
    cover = flown(circling)
    cover.weigh(np.where(late_s == LATE, 50.0, -50.0))
    turned = rotation_matrix(np.array([0.0, 0.0, -0.4 * late_s]))[:2, :2]
    off = turned @ np.array([3.0, 4.0]) - np.array([3.0, 4.0])
    np.testing.assert_allclose(added(cover), np.outer(off, off), atol=0.03)


def test_each_latency_counts_by_its_probability():
    cover = flown(lambda t: camera(5.0 * t))
    cover.weigh(np.array([-50.0, -50.0, 0.0, 3.0, -50.0]))
    odds = 0.1 / 4.0 * np.exp(3.0)
    assert added(cover)[0, 0] == pytest.approx(odds / (0.9 + odds) * 25.0, rel=1e-3)


def test_before_the_first_camera_it_moved_as_since_then():
    wider = added(flown(lambda t: camera(5.0 * t), 1.0))
    assert wider[0, 0] == pytest.approx(0.05 * (25.0 + 100.0), rel=1e-3)


def test_nothing_is_known_at_once():
    assert not added(flown(lambda t: camera(5.0 * t), 0.3)).any()
    assert not added(LatencyCover(LATE, 0.1)).any()


def test_a_camera_that_stays_says_that_no_latency_matters():
    np.testing.assert_allclose(added(flown(lambda _t: camera(0.0))), 0.0, atol=1e-9)


def test_a_camera_that_saw_the_sky_leaves_a_bounded_covariance():
    tilted = rotation_matrix(np.array([0.0, np.radians(100.0), 0.0])) @ DOWN
    sky = MapPose(np.array([0.0, 0.0, 30.0]), tilted @ FLU_FROM_OPTICAL.T)
    wider = added(flown(lambda t: camera(0.0) if t > 3.5 else sky))
    assert np.isfinite(wider).all()
    assert np.sqrt(np.trace(wider)) < 30.0 / 0.05


def test_another_map_begins_anew():
    cover = flown(lambda t: camera(5.0 * t))
    cover.forget()
    assert not added(cover).any()
    assert cover.widened([]) == []


def test_a_reference_corrects_what_displaces_all_alike():
    cover = LatencyCover(LATE, 0.1)
    for t in np.arange(0.0, 4.05, 0.1):
        cover.add(t, camera(5.0 * t, 0.2 * t), frozenset({"beacon_1"}))
    robots = [robot(23.0, 4.0, "beacon_1"), robot(23.0, 9.0)]
    own, other = (one.covariance[:2, :2] - np.eye(2) for one in cover.widened(robots))
    np.testing.assert_allclose(own, 0.0, atol=1e-12)
    chords = 2.0 * 5.0 * np.sin([0.1, 0.2])  # it seems to turn about the reference
    assert np.trace(other) == pytest.approx(0.05 * float(chords @ chords), rel=0.01)
    (alone,) = cover.widened(robots[1:])  # the reference is not there any more
    assert np.trace(alone.covariance[:2, :2]) > 5.0
