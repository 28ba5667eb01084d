# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the fleet keeps of a drone: its camera, jumps of its receiver, what it should see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.platform_model import COUNT


@pytest.fixture
def looked(two_rtk):
    """Drone b after ten images, its next sighting, and the map."""
    drone = Drone("b", two_rtk.configs["b"])
    seen = two_rtk.sightings["b"][:11]
    for one in seen[:10]:
        drone.look(one, two_rtk.local)
    return drone, seen[10], two_rtk.local


def test_a_jump_that_is_not_believed_is_taken_out_of_the_pose(looked):
    drone, seen, local = looked
    jump = np.array([5.0, -3.0, 0.0])
    view = drone.look(replace(seen, jump=jump), local)
    np.testing.assert_allclose(view.measured.position + jump, MapPose.of(seen.pose, local).position)


def test_a_jump_that_is_believed_is_no_motion(looked):
    drone, seen, local = looked
    still = np.linalg.norm(drone.view.rates[:3])
    assert not drone.jumped(seen)
    believed = replace(seen, believed=np.array([8.0, 0.0]), jump=np.array([-8.0, 0.0, 0.0]))
    assert drone.jumped(believed)
    view = drone.look(believed, local)
    assert np.linalg.norm(view.foretold - view.measured.position) < 0.3
    assert np.linalg.norm(view.rates[:3]) < still + 1.0
    assert not drone.jumped(believed)


def test_a_robot_is_expected_where_the_camera_looks(looked):
    drone, _, _ = looked
    errors, sure, unsure = np.zeros(COUNT), 0.01 * np.eye(2), 100.0 * np.eye(2)
    behind = 3.0 * drone.view.measured.position[:2]
    places = np.array([[0.0, 0.0], [0.0, 300.0], behind, [0.0, 0.0]])
    shown = drone.shows(errors, places, np.stack([sure, sure, sure, unsure]))
    assert shown[0] > 0.99
    assert shown[1:3].max() < 0.01
    assert 0.05 < shown[3] < 0.9
    other = Drone("c", estimator_config({"noise.set": "rtk"}))
    assert other.shows(errors, places, np.stack([sure] * 4)).tolist() == [0.0] * 4


def test_its_last_image_grows_old(looked):
    drone, _, _ = looked
    now_ns = drone.last.pose.stamp_ns
    assert drone.recent(now_ns + 10**9, 1.0)
    assert not drone.recent(now_ns + 10**9 + 1, 1.0)
    assert not Drone("c", estimator_config({"noise.set": "rtk"})).recent(now_ns, 1.0)


def test_a_fix_that_states_its_covariance_sets_the_prior(looked):
    drone, seen, _ = looked
    pose = replace(seen.pose, fix_covariance=np.diag([9.0, 4.0]))
    drone.state_receiver(replace(seen, pose=pose))
    np.testing.assert_array_equal(drone.stationary[:2, :2], np.diag([9.0, 4.0]))
