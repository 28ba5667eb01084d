# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What other latencies of the fix make of positions is in their covariance."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation.fix_latency_cover import FixLatencyCover
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State

LATE = np.array([-0.4, -0.2, 0.0, 0.2, 0.4])


def robot(name):
    return RobotEstimate(
        0, name, "aqua", State.CONFIRMED, 0.2, -1.0, 0.0, np.array([3.0, 4.0]), np.zeros(2),
        np.eye(4), 0,
    )  # fmt: skip


def flown(corrects=()):
    """A camera that flies east at 5 m/s, and turns."""
    cover = FixLatencyCover(LATE, 0.1)
    for t in np.arange(0.0, 2.05, 0.1):
        turn = rotation_matrix(np.array([0.0, 0.0, t]))
        cover.add(t, MapPose(np.array([5.0 * t, 0.0, 30.0]), turn), frozenset(corrects))
    return cover


def added(cover, *names):
    found = cover.widened([robot(name) for name in names])
    return [one.covariance[:2, :2] - np.eye(2) for one in found]


def test_a_robot_that_is_not_tracked_goes_with_the_camera():
    """1 or 2 m off, each way with a probability of 0.025; that the camera turns does not matter."""
    (wider,) = added(flown(), "aqua_1")
    np.testing.assert_allclose(wider, [[0.05 * (1.0 + 4.0), 0.0], [0.0, 0.0]], atol=1e-9)


def test_a_robot_that_is_tracked_is_where_each_latency_has_it():
    cover = flown()
    north = np.array([[0.0, -3.0], [0.0, -1.0], [0.0, 0.0], [0.0, 2.0], [0.0, 4.0]])
    cover.displacements = {"aqua_2": north}
    other, tracked = added(cover, "aqua_1", "aqua_2")
    assert other[0, 0] == pytest.approx(0.25)
    np.testing.assert_allclose(tracked, [[0.0, 0.0], [0.0, 0.025 * 30.0]], atol=1e-9)


def test_what_displaces_a_reference_as_well_is_corrected():
    """The camera of 0.4 s later is 2 m farther east, and shows a robot as far from there."""
    cover = flown(["pier_1"])
    east = np.array([[2.5, 0.0], [1.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [-2.5, 0.0]])
    cover.displacements = {"pier_1": east}
    _, wider = added(cover, "pier_1", "aqua_1")
    np.testing.assert_allclose(wider, [[0.05 * 0.25, 0.0], [0.0, 0.0]], atol=1e-9)
