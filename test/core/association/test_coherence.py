# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that are off each by itself have swerved; off together, the camera may have turned."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.coherence import swerves
from aerial_gnss_ros.core.faults.rotation_test import fit_rotation
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL

HEIGHT_M, SPEED = 20.0, 0.75
PLACES = np.array([[-6.0, 3.0], [5.0, 4.0], [1.0, -7.0], [-3.0, -2.0]])
THRESHOLD = 11.6
SIGMA = 0.1


def by_angles(place):
    """Return how a place under a camera that looks down moves with its three angles, m/rad."""
    east, north = place
    return np.array([[0.0, -HEIGHT_M, -north], [HEIGHT_M, 0.0, east]])


def filter_of():
    """Return what is asked of the joint filter."""
    moved = np.array([by_angles(place) for place in PLACES])

    def turned_by(rows, offsets, variances):
        return fit_rotation(offsets, variances, moved[rows], MOTION_MODEL.swerve_s * SPEED)[2]

    return SimpleNamespace(turned_by=turned_by, speeds=lambda _: SPEED)


def pairs_of(offsets):
    """Return a box for each robot, so far from where it was expected (n, 2)."""
    every = np.arange(len(offsets))
    spread = np.tile(SIGMA**2 * np.eye(2), (len(offsets), 1, 1))
    return PairInnovations(every, every, np.array(offsets, dtype=float), spread)


def turned(degrees):
    """Return the offsets of all robots by a turn of the camera about the axis of its pitch."""
    return np.array([by_angles(place)[:, 1] for place in PLACES]) * np.radians(degrees)


@pytest.mark.parametrize(
    ("offsets", "left", "chosen", "count"),
    [
        ([[0.5, 0.1], [-0.4, 0.3], [0.0, 0.0], [0.1, 0.0]], [0, 1], [2, 3], 2),
        ([[0.7, 0.1], [-0.2, 0.7], [0.2, -0.7]], [0, 1, 2], [], 3),
        (turned(2.0), [0, 1, 2, 3], [], 0),  # one turn explains all
        (turned(2.0)[:2], [0, 1], [], 0),  # of two robots nobody knows
        ([[6.0, 0.0], [0.0, -8.0], [0.0, 0.0], [0.1, 0.0]], [0, 1], [2, 3], 0),  # no swerve
        ([[0.0, 0.0], [0.1, 0.0]], [], [0, 1], 0),
    ],
    ids=["beside robots that stay", "three ways", "turned", "two alike", "far off", "none"],
)
def test_robots_off_by_themselves_have_swerved(offsets, left, chosen, count):
    assert swerves(filter_of(), pairs_of(offsets), left, chosen, THRESHOLD) == count


def test_a_box_is_one_robots():
    one = pairs_of([[0.5, 0.1], [-0.4, 0.3], [0.0, 0.0], [0.1, 0.0]])
    shared = PairInnovations(one.rows, np.array([0, 0, 2, 3]), one.offsets, one.spread)
    assert swerves(filter_of(), shared, [0, 1], [2, 3], THRESHOLD) == 1


@pytest.mark.parametrize(
    ("offset", "nats", "count"),
    [
        (0.5, -CLEAR_NATS - 0.1, 1),
        (0.5, -CLEAR_NATS + 0.1, 0),  # a turn is not clearly unlikelier
        (6.0, -1000.0, 0),  # no robot swerves as far
    ],
)
def test_a_swerve_is_within_reach_and_clearly_likelier_than_a_turn(offset, nats, count):
    joint = filter_of()
    joint.turned_by = lambda *_: nats
    assert swerves(joint, pairs_of([[offset, 0.0]]), [0], [], THRESHOLD) == count
