# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matchings of two drones' robots: by all pairs together, never by the nearest."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.constellations import matchings

PLACES = np.array([[0.0, 0.0], [3.0, 1.0], [-1.0, 4.0]])


def weighed(first, second, common=1.5, own=0.05, in_view=(0.0, 0.0), turn=0.0):
    """Weigh robots whose second drone errs by a common offset, and a rotation about (0, 0)."""
    m, n = len(first), len(second)
    offsets = np.asarray(second)[None] - np.asarray(first)[:, None]
    by = np.zeros((m, n, 2, m + n, 2))
    for i in range(m):
        for j in range(n):
            by[i, j, :, i], by[i, j, :, m + j] = -np.eye(2), np.eye(2)
    flat = by.reshape(2 * m * n, -1)
    P = own**2 * np.eye(2 * (m + n))
    shift = np.zeros((2 * (m + n), 3))
    shift[2 * m :, :2] = common * np.tile(np.eye(2), (n, 1))
    shift[2 * m :, 2] = turn * np.array([[-y, x] for x, y in second]).ravel()
    P += shift @ shift.T
    covariance = (flat @ P @ flat.T).reshape(m, n, 2, m, n, 2)
    possible = np.ones((m, n), np.bool_)
    return matchings(offsets, covariance, possible, np.full(m, in_view[0]), np.full(n, in_view[1]))


def pairs(found):
    return set(found[0].pairs)


def test_a_constellation_is_recognised_although_the_nearest_are_others():
    moved = PLACES + np.array([2.8, 0.9])  # robot 0 of the second lies on robot 1 of the first
    found = weighed(PLACES, moved)
    assert pairs(found) == {(0, 0), (1, 1), (2, 2)}
    assert found[0].probability > 0.99
    assert sum(one.probability for one in found) == pytest.approx(1.0)


def test_a_turned_constellation_needs_a_compass_that_may_be_so_wrong():
    c, s = math.cos(0.3), math.sin(0.3)
    turned = PLACES @ np.array([[c, s], [-s, c]])
    assert pairs(weighed(PLACES, turned, common=0.3, turn=0.2)) == {(0, 0), (1, 1), (2, 2)}
    assert pairs(weighed(PLACES, turned, common=0.3, turn=0.01)) != {(0, 0), (1, 1), (2, 2)}


def test_other_robots_stay_apart():
    assert pairs(weighed(PLACES[:2], np.array([30.0, 20.0]) - PLACES[:2])) == set()


def test_one_robot_alone_is_not_sure_unless_the_cameras_should_see_two():
    near = [[1.0, 0.5]]
    alone = weighed([[0.0, 0.0]], near)
    assert 0.5 < alone[0].probability < 0.999
    seen = weighed([[0.0, 0.0]], near, in_view=(1.0, 1.0))
    assert pairs(seen) == {(0, 0)}
    assert seen[0].probability > 0.999


def test_one_robot_is_never_two():
    both = weighed([[0.0, 0.0], [0.2, 0.0]], [[0.1, 0.0]], common=0.1)
    assert all(len({j for _, j in one.pairs}) == len(one.pairs) for one in both)
    assert both[0].probability < 0.999


def test_a_pair_of_two_classes_is_impossible():
    offsets, covariance = np.zeros((1, 1, 2)), 0.1 * np.eye(2).reshape(1, 1, 2, 1, 1, 2)
    none = np.zeros((1, 1), np.bool_)
    found = matchings(offsets, covariance, none, np.ones(1), np.ones(1))
    assert [one.pairs for one in found] == [()]


def test_many_robots_are_weighed_in_bounded_number():
    rng = np.random.default_rng(1)
    places = rng.uniform(-3.0, 3.0, (12, 2))
    found = weighed(places, places + 0.1)
    assert len(found) <= 2000
    assert set(found[0].pairs) <= {(i, i) for i in range(12)}
