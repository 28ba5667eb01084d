# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which pairs of tracks and boxes there are to choose from."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.gating import NEITHER, NEW, ROBOT, CandidatePairs
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

GATE = 9.0  # a radius of 3 m, since covariances are of 1 m²; just outside it is up to 9 m


def candidates(apart, kind, tracks=("aqua",) * 3, boxes=("aqua",) * 3, every=()):
    """Return the pairs of all tracks with all boxes, so far apart (n, m), m."""
    apart = np.array(apart, dtype=float)
    rows, columns = np.divmod(np.arange(apart.size), apart.shape[1])
    offsets = np.column_stack([apart.ravel(), np.zeros(apart.size)])
    pairs = PairInnovations(rows, columns, offsets, np.tile(np.eye(2), (apart.size, 1, 1)))
    every = list(every) or [Track(name, 0, 0) for name in tracks[: len(kind)]]
    distances = mahalanobis(pairs.offsets, pairs.spread)
    return CandidatePairs.of_image(pairs, distances, list(kind), every, list(boxes), GATE)


def test_robots_and_new_tracks_have_their_own_lists():
    found = candidates([[2.0, 8.0], [2.9, 3.1], [1.0, 9.1]], [ROBOT, NEW, NEITHER])
    assert (found.robots, found.inside) == ([0, 1], [0])
    assert (found.new_near, found.new_inside) == ([2, 3], [2])
    assert candidates([[1.0, 9.1]], [NEW]).new_near == [0]


def test_a_box_of_another_class_is_in_no_list():
    found = candidates([[1.0, 1.0]], [ROBOT], boxes=("buoy", "aqua"))
    assert (found.robots, found.inside) == ([1], [1])


def test_the_nearest_box_is_one_robots_and_no_box_is_two_robots():
    found = candidates([[2.0, 1.0], [0.5, 4.0], [9.1, 9.2]], [ROBOT] * 3)
    assert found.nearest == [2, 1]
    assert not found.lone


def test_alone_are_a_robot_and_a_box_with_no_other_one_near():
    assert candidates([[2.0, 9.1], [9.1, 8.0], [9.2, 8.5]], [ROBOT] * 3).lone == {0}
    assert not candidates([[2.0, 8.0]], [ROBOT]).lone


@pytest.mark.parametrize(
    ("apart", "hits", "alone"),
    [(2.0, (5, 6), False), (2.0, (6, 8), True), (3.1, (5, 6), True)],
    ids=["another robot", "perhaps the robot itself", "outside its gate"],
)
def test_a_box_of_what_was_seen_beside_a_robot_is_not_the_robots(apart, hits, alone):
    robot, new = Track("aqua", 0, 5, hits=(4, 5)), Track("aqua", 0, 8, hits=hits)
    found = candidates([[8.0], [apart]], [ROBOT, NEW], every=[robot, new])
    assert found.nearest == [0]
    assert found.lone == ({0} if alone else set())


@pytest.mark.parametrize(
    ("apart", "doubtful", "near"),
    [
        ([[1.0, 9.1], [8.0, 1.0]], False, [0, 2, 3]),
        ([[1.0, 2.0], [8.0, 1.0]], True, [0, 1, 2, 3]),  # two boxes in one gate
        ([[1.0], [9.1]], True, [0]),  # the second one has no box
    ],
)
def test_whose_a_box_is_may_be_doubtful(apart, doubtful, near):
    found = candidates(apart, [ROBOT] * 2)
    assert (found.doubtful, found.near) == (doubtful, near)


def test_the_best_pairs_are_the_likeliest_all_together():
    found = candidates([[1.0, 2.0], [1.1, 9.0]], [ROBOT] * 2)
    assert found.inside == [0, 1, 2]
    assert found.best(found.inside) == [1, 2]
    assert found.best([0]) == [0]


def test_robots_and_boxes_left_over_and_which_of_them_nearly_met():
    found = candidates([[1.0, 8.0, 8.0], [5.0, 8.9, 9.0], [5.0, 9.1, 30.0]], [ROBOT] * 3)
    assert found.left([0]) == ([4, 5, 7, 8], 1)


def test_only_robots_with_a_box_near_their_gates_are_missed():
    found = candidates([[1.0, 30.0], [5.0, 8.9], [5.0, 9.1], [5.0, 30.0]], [ROBOT] * 4,
                       tracks=("aqua",) * 4)  # fmt: skip
    assert found.left([0]) == ([3, 5, 7], 1)
