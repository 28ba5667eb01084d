# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot moves when that is sure, until it stands."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.fleet.moving_robots import moving
from aerial_gnss_ros.core.models.platform_model import COUNT


def robots(speed, sigma):
    """Two robots with that uncertainty of each axis; the second one stays."""
    joint = JointState(np.eye(COUNT))
    white = np.tile(np.eye(2), (2, 1, 1))
    joint.add(np.arange(2), np.zeros((2, 2)), np.zeros((2, 2, COUNT)), white, sigma)
    joint.robots[0, 2:] = 0.6 * speed, -0.8 * speed
    return joint


@pytest.mark.parametrize(
    ("speed", "sigma", "begins", "goes_on"),
    [
        (0.09, 0.02, False, True), (0.11, 0.02, False, True), (0.12, 0.02, True, True),
        (0.02, 0.02, False, False), (0.09, 0.001, False, True), (0.031, 0.001, False, True),
        (0.029, 0.001, False, False), (0.11, 0.001, True, True),
    ],
)  # fmt: skip
def test_a_robot_moves_when_that_is_sure_until_it_stands(speed, sigma, begins, goes_on):
    joint = robots(speed, sigma)
    for before, expected in ((False, begins), (True, goes_on)):
        assert moving(joint, np.full(2, before)).tolist() == [expected, False]
