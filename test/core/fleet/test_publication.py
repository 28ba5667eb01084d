# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Covariances of robots that other drones do not show are widened, others are not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.publication import displaced, platform_errors, published
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.values.estimates import State


def test_robots_in_doubt_are_widened_and_those_of_the_same_drone_too(two_rtk):
    fleet, updates = two_rtk.together()
    _, seen, update = updates[-1]
    now_ns = seen.pose.stamp_ns
    assert displaced(fleet.table.robots, 1, now_ns) == 0.0
    joint = fleet.table.state.joint

    def told():
        return published(
            joint.robots, joint.blocks(), fleet.table.robots, fleet._drones, seen, fleet.local
        )

    plain = told()
    assert [one.robot_id for one in plain] == [one.robot_id for one in update.estimates]
    assert {one.state for one in plain} == {State.CONFIRMED}
    one, other, _ = sorted(fleet.table.robots, key=lambda robot: robot.name)
    one.labels, other.labels = {1: "x"}, {1: "y"}
    one.note_rival(np.array([3.0, 4.0]), now_ns - 10**10)
    one.note_rival(np.array([3.0, 4.0]), now_ns)
    assert displaced(fleet.table.robots, 1, now_ns) == 5.0
    assert displaced(fleet.table.robots, 0, now_ns) == 0.0
    wide = told()
    more = [b.covariance[:2, :2] - a.covariance[:2, :2] for a, b in zip(plain, wide, strict=True)]
    np.testing.assert_allclose(more[0], [[9.0, 12.0], [12.0, 16.0]], atol=1e-9)
    np.testing.assert_allclose(more[1], 25.0 * np.eye(2), atol=1e-9)
    assert more[2] == pytest.approx(np.zeros((2, 2)))


def test_errors_of_several_drones_have_their_names_and_that_of_one_alone_none():
    drones = [SimpleNamespace(name=name, view=None) for name in "ab"]
    errors, spread = np.arange(2.0 * COUNT), np.diag([4.0, *[0.0] * (2 * COUNT - 2), 9.0])
    found = platform_errors(drones, errors, spread)
    assert [(one.name, one.value, one.sigma) for one in found] == [
        ("a gnss_east", 0.0, 2.0),
        ("b clock", 17.0, 3.0),
    ]
    (alone,) = platform_errors(drones[:1], errors[:COUNT], spread[:COUNT, :COUNT])
    assert alone.name == "gnss_east"
