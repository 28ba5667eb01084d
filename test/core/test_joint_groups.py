# SPDX-License-Identifier: Apache-2.0
"""Robots in several groups answer by row as if they were in one."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core import joint_groups
from aerial_gnss_ros.core.joint_groups import Groups
from aerial_gnss_ros.core.joint_platform import COUNT


@pytest.fixture
def five(monkeypatch):
    """Robot i stands at (i, 2 i), known to 1 m² + i; groups of two."""
    monkeypatch.setattr(joint_groups, "GROUP", 2)
    groups = Groups()
    groups.clear(np.eye(COUNT))
    for group, rows, columns in groups.room(np.arange(5)):
        places = np.stack([columns, 2.0 * columns], axis=1)
        white = np.eye(2) * (1.0 + columns)[:, None, None]
        group.add(rows, places, np.zeros((len(rows), 2, COUNT)), white, 0.5)
    return groups


def _east(groups):
    return groups.mean[:, 0].tolist()


def test_rows_keep_their_order_whatever_group_they_are_in(five):
    assert len(five) == 5
    assert len(five._groups) == 3
    assert _east(five) == [0, 1, 2, 3, 4]
    assert five.covariance[:, 0, 0] == pytest.approx([1, 2, 3, 4, 5])


def test_rows_after_a_dropped_one_move_up_and_its_room_is_used(five):
    five.drop(np.array([1, 2, 3]))
    assert _east(five) == [0, 4]
    for group, rows, _ in five.room(np.arange(1)):
        group.add(rows, np.array([[9.0, 9.0]]), np.zeros((1, 2, COUNT)), np.eye(2)[None], 0.5)
    assert _east(five) == [0, 4, 9]
    assert len(five._groups) == 2


def test_offsets_between_groups_add_what_is_unsure(five):
    offsets, spread = five.apart(np.array([0, 3]), np.array([4]))
    assert offsets[:, 0].tolist() == [[4.0, 8.0], [1.0, 2.0]]
    assert spread[:, 0, 0, 0] == pytest.approx([1 + 5, 4 + 5])


def test_only_robots_named_are_loosened(five):
    five.loosen(np.array([3]), 1.0, 2.0)
    assert five.covariance[:, 0, 0] == pytest.approx([1, 2, 3, 4 + 4, 5])
