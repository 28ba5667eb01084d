# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot is on one track only: what one track tells about another."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays
from hypothesis.strategies import data, floats, integers, tuples

from aerial_gnss_ros.core.identity.return_assignment import (
    TUNING,
    Pairs,
    exclusive_probabilities,
)


def test_a_single_track_is_shared_by_robots_and_a_new_one():
    assert exclusive_probabilities(np.array([[6.0], [3.0]]))[:, 0] == pytest.approx([0.6, 0.3])


def test_two_tracks_each_near_one_robot_are_clearer_together_than_alone():
    odds = np.array([[90.0, 9.0], [9.0, 90.0]])
    alone = odds[0, 0] / (1.0 + odds[:, 0].sum())
    together = exclusive_probabilities(odds)
    whole = 1.0 + odds.sum() + odds[0, 0] * odds[1, 1] + odds[0, 1] * odds[1, 0]
    assert together[0, 0] == pytest.approx((odds[0, 0] + odds[0, 0] * odds[1, 1]) / whole)
    assert alone < 0.91
    assert together[0, 0] > 0.97


def summed(odds):
    """Return the probabilities by all assignments, one by one."""
    robots, tracks = odds.shape
    found, whole = np.zeros(odds.shape), 0.0
    for rows in product(range(-1, robots), repeat=tracks):
        taken = [row for row in rows if row >= 0]
        if len(set(taken)) < len(taken):
            continue
        pairs = [(row, j) for j, row in enumerate(rows) if row >= 0]
        weight = math.prod(odds[pair] for pair in pairs)
        whole += weight
        for pair in pairs:
            found[pair] += weight
    return found / whole


@given(data())
def test_probabilities_are_those_of_all_assignments_together(given_data):
    shape = given_data.draw(tuples(integers(1, 4), integers(1, 4)))
    ratios = given_data.draw(arrays(np.float64, shape, elements=floats(-9.0, 9.0)))
    possible = given_data.draw(arrays(np.bool_, shape))
    odds = np.where(possible, np.exp(ratios), 0.0)
    np.testing.assert_allclose(exclusive_probabilities(odds), summed(odds), atol=1e-9)


def test_no_tracks_and_no_robots_have_no_probabilities():
    assert exclusive_probabilities(np.zeros((3, 0))).shape == (3, 0)
    assert exclusive_probabilities(np.zeros((0, 3))).shape == (0, 3)


def test_what_is_impossible_stays_so_and_many_tracks_stay_possible():
    odds = np.full((12, 12), 2.0) + 1e4 * np.eye(12)
    odds[0, 1] = 0.0
    found = exclusive_probabilities(odds)
    assert found[0, 1] == 0.0
    assert found.diagonal() == pytest.approx(np.ones(12), abs=1e-2)
    assert found.sum(axis=0).max() <= 1.0 + 1e-9
    assert 2 ** len(odds) > TUNING.most_hypotheses  # unlikely sets are left out


def test_what_a_track_may_be_is_kept_by_label_without_the_negligible():
    ratio = np.array([[5.0], [0.0], [1e-6]])
    one = np.ones((3, 1))
    pairs = Pairs(ratio > 0.0, 2.0 * one, 3.0 * one, ratio, 4.0 * one)
    kept = pairs.of(0, ["a", "b", "c"])
    assert kept == {"a": (2.0, 3.0, 5.0, 4.0)}
    both = pairs.beside(pairs)
    assert both.ratio.tolist() == [[5.0, 5.0], [0.0, 0.0], [1e-6, 1e-6]]
