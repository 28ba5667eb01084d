# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots as they were before they were contradicted: when they are gone back to."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.faults.rotation_fault import RotationFault
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.tracker.fork import TUNING as FORK
from aerial_gnss_ros.core.tracker.fork import Fork
from aerial_gnss_ros.core.values.estimates import State

SECOND = 1_000_000_000
GATE = 9.0


def _fork(count=3, **changes):
    tracks = [Track("aqua", 0, SECOND, State.CONFIRMED, f"aqua_{k}") for k in range(count)]
    for name, value in changes.items():
        setattr(tracks[0], name, value)
    return Fork.of(SECOND, tracks, [])


def _pairs(*apart):
    """Return an image of as many boxes, each so far from the robot of its number, m."""
    every = np.arange(len(apart))
    offsets = np.column_stack([apart, np.zeros(len(apart))])
    return PairInnovations(every, every, offsets, np.tile(np.eye(2), (len(apart), 1, 1)))


def _taken(fork, *images):
    return [fork.update(_pairs(*apart), len(apart), GATE) for apart in images]


def test_it_takes_images_in_a_row_that_show_all_robots_at_home():
    good, bad = (0.0, 2.9, -1.0), (0.0, 3.1, 0.0)
    assert _taken(_fork(), *[good] * FORK.agreeing_images) == [False] * (
        FORK.agreeing_images - 1
    ) + [True]
    assert not any(_taken(_fork(), *[good, good, bad] * 3))


def test_one_robot_at_home_may_be_chance():
    assert not any(_taken(_fork(1), *[(0.0,)] * 10))
    assert not any(_taken(_fork(), *[(0.0,)] * 10))


@pytest.mark.parametrize(
    "change",
    [{"robot_id": ""}, {"leaving_view": True}, {"last_seen_ns": -1}, {"state": State.TENTATIVE}],
    ids=str,
)
def test_robots_that_were_not_in_view_need_not_come_back(change):
    assert _taken(_fork(**change), *[(90.0, 0.0, 0.0)] * FORK.agreeing_images)[-1]
    assert not any(_taken(_fork(), *[(90.0, 0.0, 0.0)] * 10))


def test_it_ends_when_nothing_contradicts_for_a_while():
    fork = _fork()
    assert fork.holds(2 * SECOND)
    fork.calm_s = FORK.calm_s + 0.01
    assert not fork.holds(2 * SECOND)
    fork.calm_s = 0.0
    assert not fork.holds(round((FORK.longest_s + 1.1) * SECOND))


def test_what_it_keeps_does_not_change_with_the_tracks():
    tracks = [Track("aqua", 0, 0, State.CONFIRMED, "aqua_1"), Track("aqua", 0, 0)]
    fork = Fork.of(0, tracks, [])
    tracks[0].robot_id = ""
    assert fork.tracks[0].robot_id == "aqua_1"
    assert fork.unnamed == [1]


def test_it_says_how_far_robots_are_from_where_these_should_be():
    joint = JointState(np.diag([1.0, 1.0, 0.1, 1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0]))
    joint.add(
        np.arange(3), np.zeros((3, 2)), np.zeros((3, 2, COUNT)), np.tile(np.eye(2), (3, 1, 1)), 1
    )
    fork = Fork.of(SECOND, _fork().tracks, [joint])
    joint.mean += 7.0  # of the filter, which goes on
    mean = np.array([[9.0, 9.0], [2.4, 0.0], [0.0, -2.5]])
    near, far = fork.apart({"aqua_0": 1}, mean), fork.apart({"aqua_2": 2, "aqua_9": 0}, mean)
    np.testing.assert_allclose(near["aqua_0"], [2.4, 0.0])
    assert list(far) == ["aqua_2"]
    again = fork.again()
    fork.groups[0].mean += 1.0
    np.testing.assert_allclose(again.apart({"aqua_0": 1}, mean)["aqua_0"], [2.4, 0.0])


def test_its_robots_have_one_camera_and_not_that_of_the_filter():
    camera = RotationFault()
    groups = [JointState(np.eye(COUNT), camera), JointState(np.eye(COUNT), camera)]
    fork = Fork.of(SECOND, [], groups)
    kept = fork.groups[0].rotation_fault
    assert kept is fork.groups[1].rotation_fault
    assert kept is not camera
    assert kept.ambiguity is camera.ambiguity  # what no robots explained, none of them did
