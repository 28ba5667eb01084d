# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that are all displaced are identified by their relative positions."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.formation import formation

PLACES = np.array([[0.0, 20.0], [6.0, 24.0], [-3.0, 15.0], [4.0, 31.0], [-7.0, 27.0]])
HEIGHT = 20.0


def by_angles(places):
    """(n, 2, 3) of a camera 20 m above East, North 0: w x o of each axis, brought to the water."""
    found = np.zeros((len(places), 2, 3))
    for i, (x, y) in enumerate(places):
        o = np.array([x, y, -HEIGHT])
        for k, axis in enumerate(np.eye(3)):
            moved = np.cross(axis, o)
            found[i, :, k] = (moved - o * moved[2] / o[2])[:2]
    return found


def asked(old, new, sigma=0.3):
    offsets = new[None] - old[:, None]
    spread = np.broadcast_to(sigma**2 * np.eye(2), (*offsets.shape, 2))
    possible = np.ones(offsets.shape[:2], dtype=bool)
    return formation(offsets, spread, by_angles(old), old.copy(), possible)


@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize("degrees", [(6.0, 0.0, 0.0), (0.0, 0.0, -15.0)])
def test_a_turn_of_the_camera_keeps_names(count, degrees):
    old, turn = PLACES[:count], np.radians(degrees)
    order = np.random.default_rng(1).permutation(count)
    new = (old + by_angles(old) @ turn)[order]
    found = asked(old, new)
    assert found.moved
    assert [old for old, _ in found.pairs] == list(range(count))
    assert [order[new] for _, new in found.pairs] == list(range(count))
    off = found.turn - turn
    assert off @ np.linalg.solve(found.spread, off) < 12.0
    # what the turn does to places is known better than how it is made up of its angles
    assert by_angles(old) @ found.turn == pytest.approx(by_angles(old) @ turn, abs=1.0)


def test_robots_that_are_where_they_were_have_not_moved():
    found = asked(PLACES[:3], PLACES[:3] + 0.2)
    assert not found.moved
    assert found.pairs == ((0, 0), (1, 1), (2, 2))
    assert not found.turn.any()


def test_a_zoom_or_a_wrong_height_keeps_names():
    found = asked(PLACES[:3], 1.3 * PLACES[:3])
    assert found.moved
    assert found.pairs == ((0, 0), (1, 1), (2, 2))


def test_one_robot_or_two_of_four_are_no_formation():
    turned = PLACES + by_angles(PLACES) @ np.radians([6.0, 0.0, 0.0])
    assert asked(PLACES[:1], turned[:1]) is None
    assert asked(PLACES[:4], turned[:2]) is None


def test_robots_that_lie_alike_are_not_distinguished():
    """Two of three on a line, as far from one another as the third: either end may be missing."""
    line = np.array([[-4.0, 20.0], [0.0, 20.0], [4.0, 20.0]])
    assert asked(line, line[:2] + np.array([2.0, 0.0])) is None


def test_another_formation_fits_none():
    other = np.array([[0.0, 20.0], [15.0, 22.0], [3.0, 6.0]])
    assert asked(PLACES[:3], other, sigma=0.1) is None


def test_a_class_that_cannot_be_is_not_it():
    old = PLACES[:2]
    offsets = old[None] - old[:, None]
    spread = np.broadcast_to(0.09 * np.eye(2), (2, 2, 2, 2))
    possible = ~np.eye(2, dtype=bool)
    found = formation(offsets, spread, by_angles(old), old, possible)
    assert found is None or found.pairs == ((0, 1), (1, 0))
