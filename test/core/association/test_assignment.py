# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Assignment against brute force."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.association.assignment import assign, lone


def _brute(cost, allowed, edges):
    """Return the least total cost over all partial assignments."""
    n, m = cost.shape
    best = np.inf
    for picks in permutations([*range(m), *[None] * n], n):
        if any(j is not None and not allowed[i, j] for i, j in enumerate(picks)):
            continue
        total = sum(edges[i] if j is None else cost[i, j] for i, j in enumerate(picks))
        best = min(best, total)
    return best


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 3), st.integers(1, 3), st.integers(0, 10_000))
def test_assignment_is_the_best_of_all(n, m, seed):
    rng = np.random.default_rng(seed)
    squared, width = rng.uniform(0.0, 15.0, (n, m)), rng.normal(0.0, 2.0, (n, m))
    allowed = squared < 11.6
    rows, columns = assign(squared, width, allowed, 11.6)
    edges = np.array([11.6 + max(width[i][allowed[i]], default=0.0) for i in range(n)])
    cost = squared + width
    total = cost[rows, columns].sum() + np.delete(edges, rows).sum()
    assert allowed[rows, columns].all()
    assert len(set(columns.tolist())) == len(columns)
    assert total == pytest.approx(_brute(cost, allowed, edges))


def test_a_missed_robot_does_not_push_its_neighbour_aside():
    # robot 1 sees its own box 0 well; robot 0 was missed, and a false box 1 lies in 1's gate
    squared = np.array([[10.0, 40.0], [0.2, 9.0]])
    rows, columns = assign(squared, np.zeros((2, 2)), squared < 11.6, 11.6)
    assert (rows.tolist(), columns.tolist()) == ([1], [0])


def test_nothing_to_assign():
    rows, columns = assign(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), bool), 11.6)
    assert len(rows) == len(columns) == 0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 6), st.integers(0, 6), st.integers(0, 10_000))
def test_lone_pairs_share_no_row_and_no_column_with_any_other(n, m, seed):
    allowed = np.random.default_rng(seed).random((n, m)) < 0.3
    rows, columns = np.nonzero(allowed)
    expected = (allowed.sum(axis=1)[rows] == 1) & (allowed.sum(axis=0)[columns] == 1)
    assert lone(rows.tolist(), columns.tolist()) == expected.tolist()
