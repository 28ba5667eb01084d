# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matchings of two drones' robots: by all pairs together, never by the nearest."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.constellations import TUNING, Candidates, matchings

PLACES = np.array([[0.0, 0.0], [3.0, 1.0], [-1.0, 4.0]])


def weighed(first, second, common=1.5, own=0.05, in_view=(0.0, 0.0), turn=0.0):
    """Weigh robots whose second drone errs by a common offset, and a rotation about (0, 0)."""
    places, P = law(first, second, common, own, turn)
    m, n = len(first), len(second)
    candidates = Candidates.of(places, P, np.ones((m, n), np.bool_))
    return matchings(candidates, np.full(m, in_view[0]), np.full(n, in_view[1]))


def law(first, second, common, own, turn):
    """Return all places, and their covariance."""
    m, n = len(first), len(second)
    P = own**2 * np.eye(2 * (m + n))
    shift = np.zeros((2 * (m + n), 3))
    shift[2 * m :, :2] = common * np.tile(np.eye(2), (n, 1))
    shift[2 * m :, 2] = turn * np.array([[-y, x] for x, y in second]).ravel()
    P += shift @ shift.T
    return np.concatenate([first, second]), P.reshape(m + n, 2, m + n, 2)


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
    P = 0.1 * np.eye(4).reshape(2, 2, 2, 2)
    candidates = Candidates.of(np.zeros((2, 2)), P, np.zeros((1, 1), np.bool_))
    assert [one.pairs for one in matchings(candidates, np.ones(1), np.ones(1))] == [()]


def test_probabilities_are_those_of_all_matchings_written_out():
    """By the dense normal density of each, against robots by their density around each place."""
    rng = np.random.default_rng(3)
    second = PLACES + np.array([0.6, -0.5]) + 0.2 * rng.normal(size=(3, 2))
    in_view = np.array([0.9, 0.3, 0.6]), np.array([0.2, 0.8, 0.5])
    places, P = law(PLACES, second, 1.5, 0.8, 0.05)
    dense = P.reshape(12, 12)
    apart = np.square(second[:, None] - second).sum(axis=2)
    density = np.exp(-0.5 * apart / 100.0).sum(axis=1) / (200.0 * math.pi)
    weights = {}
    for chosen in itertools.product((None, 0, 1, 2), repeat=3):
        used = [(i, j) for i, j in enumerate(chosen) if j is not None]
        if len({j for _, j in used}) < len(used):
            continue
        H = np.zeros((2 * len(used), 12))
        for k, (i, j) in enumerate(used):
            H[2 * k : 2 * k + 2, 2 * i : 2 * i + 2] = -np.eye(2)
            H[2 * k : 2 * k + 2, 6 + 2 * j : 8 + 2 * j] = np.eye(2)
        spread = H @ dense @ H.T + 0.1**2 * np.eye(len(H))
        offset = H @ places.ravel()
        log = -0.5 * (offset @ np.linalg.solve(spread, offset)) if used else 0.0
        log -= 0.5 * np.linalg.slogdet(2.0 * math.pi * spread)[1] if used else 0.0
        for i in {0, 1, 2} - {i for i, _ in used}:
            log += math.log(1.0 - 0.95 * in_view[0][i])
        for j in {0, 1, 2} - {j for _, j in used}:
            log += math.log(1.0 - 0.95 * in_view[1][j])
        log -= math.log(math.comb(3, len(used)))  # any number is as likely
        weights[tuple(used)] = math.exp(log) / np.prod([density[j] for _, j in used])
    total = sum(weights.values())
    candidates = Candidates.of(places, P, np.ones((3, 3), np.bool_))
    found = matchings(candidates, *in_view)
    assert len(found) > 4
    for one in found:
        assert one.probability == pytest.approx(weights[one.pairs] / total, abs=0.002)
        assert one.gain == pytest.approx(math.log(weights[one.pairs] / weights[()]))


def swarm(rng, shared, robots=30):
    """Return two drones' robots, and which of the second's each of the first's is."""
    first, second = rng.uniform(-20.0, 20.0, (2, robots, 2))
    second[:shared] = first[:shared]
    order = rng.permutation(robots)
    offset = np.array([2.0, -1.5])
    seen = second[order] + offset + 0.05 * rng.normal(size=(robots, 2))
    return first, seen, {(int(i), k) for k, i in enumerate(order) if i < shared}


def test_thirty_robots_are_recognised_by_their_constellation():
    first, second, right = swarm(np.random.default_rng(1), 30)
    found = weighed(first, second, common=2.0)
    assert len(found) <= TUNING.largest_count
    assert pairs(found) == right


def test_robots_that_both_drones_show_are_found_among_others():
    first, second, right = swarm(np.random.default_rng(2), 10)
    found = weighed(first, second, common=2.0)
    assert pairs(found) >= right
    assert len(pairs(found)) <= 12


@pytest.mark.parametrize("seed", [3, 4, 5, 6, 7, 8])
def test_many_robots_agree_by_chance_and_are_not_taken_for_one(seed):
    """With thirty others around, some four of thirty lie like four of the other's."""
    first, second, _ = swarm(np.random.default_rng(seed), 0)
    found = weighed(first, second, common=2.0)
    shares = {}
    for one in found:
        for pair in one.pairs:
            shares[pair] = shares.get(pair, 0.0) + one.probability
    assert max(shares.values(), default=0.0) < 0.99


def test_where_pairs_are_too_many_robots_wait():
    places = np.zeros((42, 2))
    candidates = Candidates.of(
        places, np.eye(84).reshape(42, 2, 42, 2), np.ones((21, 21), np.bool_)
    )
    assert not candidates.whole
    assert len(candidates) == 21 * (TUNING.largest_pairs // 21)
    assert np.bincount(candidates.first).tolist().count(21) == TUNING.largest_pairs // 21
