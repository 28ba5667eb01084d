# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Seconds in which a camera moves or turns."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation.time_in_motion import TUNING, TimeInMotion
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose

SECOND = 1_000_000_000


def pose(east=0.0, yaw=0.0):
    return MapPose(np.array([east, 0.0, 30.0]), matrix_from_rpy(0.0, 0.5, yaw))


@pytest.mark.parametrize(
    ("speed", "turn", "moves"),
    [
        (0.9 * TUNING.moving_mps, 0.9 * TUNING.turning_radps, False),
        (-1.1 * TUNING.moving_mps, 0.0, True),
        (0.0, -1.1 * TUNING.turning_radps, True),
    ],
)
def test_what_moves_or_turns_fast_enough_counts(speed, turn, moves):
    motion = TimeInMotion()
    for t in (0, 2, 4):
        motion.update(t * SECOND, pose(speed * t, math.pi + turn * t))
    assert motion.total_s == (4.0 if moves else 0.0)


def test_an_interruption_does_not_count_nor_does_a_stamp_that_goes_back():
    motion = TimeInMotion()
    motion.update(0, pose(0.0))
    motion.interrupt()
    motion.update(10 * SECOND, pose(100.0))
    assert motion.total_s == 0.0
    motion.update(9 * SECOND, pose(50.0))
    assert motion.total_s == 0.0
    motion.update(10 * SECOND, pose(60.0))
    assert motion.total_s == 1.0


def test_after_a_minute_in_motion_images_are_compared_each_second():
    motion = TimeInMotion()
    for t in range(61):
        motion.update(t * SECOND, pose(2.0 * t))
    assert (motion.total_s, motion.long, motion.pause_s) == (60.0, False, 0.4)
    motion.update(61 * SECOND, pose(122.0))
    assert (motion.long, motion.pause_s) == (True, 1.0)
