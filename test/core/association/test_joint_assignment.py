# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes that one error of the pose displaces together keep their robots."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.joint_assignment import jointly_likeliest

GATE = 11.6


def assigned(robots, boxes, common, own, image=None):
    """Return the boxes of robots (east, m) by pairs near their gates, None without one.

    Args:
        robots: their places.
        boxes: theirs.
        common: variance of the error that all boxes have, m².
        own: of each box's error, m².
        image: the label probabilities of each robot's boxes, by tracking in the image.
    """
    offsets = np.subtract.outer(np.array(boxes), np.array(robots)).T
    rows, columns = np.nonzero(offsets**2 < 9.0 * GATE * (common + own))
    apart = np.zeros((len(rows), 2))
    apart[:, 0] = offsets[rows, columns]
    covariance = np.kron(np.full((len(rows), len(rows)), common), np.eye(2))
    covariance += np.kron(own * np.equal.outer(columns, columns), np.eye(2))
    cost = np.zeros(len(rows)) if image is None else -2.0 * np.log(np.array(image)[rows, columns])
    chosen = jointly_likeliest(rows.tolist(), columns.tolist(), apart, covariance, GATE, cost)
    found = {int(rows[k]): int(columns[k]) for k in chosen}
    return [found.get(row) for row in range(len(robots))]


@pytest.mark.parametrize(
    ("robots", "boxes", "common", "expected"),
    [
        # All are displaced by the distance of two neighbours.
        ([0.0, 2.0, 4.0], [2.0, 4.0, 6.0], 4.0, [0, 1, 2]),
        ([0.0, 2.0, 4.0], [2.0, 4.0, 6.0], 0.0, [None, 0, 1]),  # no error could do that
        # The third one is not shown, the fourth box is a new robot's.
        ([0.0, 2.0, 5.0], [2.1, 4.0, 9.5], 4.0, [0, 1, None]),
        ([0.0, 3.0], [0.1, 2.9], 4.0, [0, 1]),
        ([0.0, 3.0], [2.9, 0.1], 4.0, [1, 0]),
        ([0.0, 1.0], [1.1], 0.0, [None, 0]),
    ],
)
def test_the_error_that_moves_all_boxes_is_one(robots, boxes, common, expected):
    assert assigned(robots, boxes, common, own=0.02) == expected


def test_a_box_outside_its_gate_is_its_robots_if_the_error_of_another_one_says_so():
    """All boxes are 7 m off, 3.5 sigmas. The second box lies near the third robot's place."""
    robots, boxes = [0.0, 20.0, 27.2], [6.8, 27.0, 34.2]
    assert assigned(robots, boxes, 4.0, own=0.02) == [0, 1, 2]
    assert assigned(robots, [7.5, 27.0, 34.8], 4.0, own=0.02)[0] is None  # and none without one


@pytest.mark.parametrize(
    ("image", "expected"),
    [(((0.5, 0.5), (0.5, 0.5)), [1, 0]), (((0.9, 0.1), (0.1, 0.9)), [0, 1])],
)
def test_where_positions_hardly_tell_the_picture_does(image, expected):
    assert assigned([0.0, 1.0], [0.6, 0.5], 0.0, own=1.0, image=image) == expected
