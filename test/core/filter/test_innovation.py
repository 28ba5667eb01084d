# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which pairs of robots and detections are compared: none that matters is left out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.filter.innovation import (
    TUNING,
    PairInnovations,
    joint_covariance,
    misfit,
    pair_innovations,
)
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis


def _group(rng, robots):
    group = JointState(np.eye(COUNT))
    root = rng.normal(size=(COUNT + 4 * robots, COUNT + 4 * robots))
    group.covariance = root @ root.T / len(root)
    group.mean = np.concatenate([np.zeros(COUNT), rng.normal(0.0, 30.0, 4 * robots)])
    group.rows = np.arange(robots)
    return group


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 20), st.integers(1, 20), st.integers(0, 10_000))
def test_no_pair_within_the_bound_is_left_out(n, m, seed):
    rng = np.random.default_rng(seed)
    group, places = _group(rng, n), rng.normal(0.0, 30.0, (m, 2))
    seen = places, rng.normal(size=(m, 2, COUNT)), np.tile(0.1 * np.eye(2), (m, 1, 1))
    everything = pair_innovations(group, *seen, np.inf, np.inf)
    near = pair_innovations(group, *seen, 11.6, 0.0)
    squared, _ = mahalanobis(everything.offsets, everything.spread)
    inside = squared <= 11.6
    wanted = set(zip(everything.rows[inside], everything.columns[inside], strict=True))
    found = set(zip(near.rows, near.columns, strict=True))
    assert wanted <= found
    assert len(everything.rows) == n * m
    if n * m > TUNING.few_pairs:
        trace = np.trace(everything.spread, axis1=1, axis2=2)
        bound = np.sum(everything.offsets**2, axis=1) <= 11.6 * trace
        assert found == set(zip(everything.rows[bound], everything.columns[bound], strict=True))


def test_pairs_of_groups_come_by_row_then_by_column():
    def part(rows, columns):
        count = len(rows)
        return PairInnovations(
            np.array(rows), np.array(columns), np.array([rows, columns], float).T,
            np.zeros((count, 2, 2)),
        )  # fmt: skip

    whole = PairInnovations.of_groups([part([0, 3, 3], [1, 0, 2]), part([1, 2], [5, 4])])
    assert whole.rows.tolist() == [0, 1, 2, 3, 3]
    assert whole.columns.tolist() == [1, 5, 4, 0, 2]
    assert whole.offsets[:, 1].tolist() == pytest.approx([1, 5, 4, 0, 2])


def test_misfit_counts_each_box_once_and_what_is_beyond_the_gate_as_its_edge():
    pairs = PairInnovations(
        np.array([0, 0, 1, 2, 3]), np.array([0, 1, 0, 2, 3]),
        np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [9.0, 0.0], [0.0, 0.0]]),
        np.tile(np.eye(2), (5, 1, 1)),
    )  # fmt: skip
    # Robot 0 has box 0 from 1, which so has none; 2's is beyond the gate; 3 is not expected.
    assert misfit(pairs, [0, 1, 2], 16.0) == pytest.approx(0.5 * (1.0 + 16.0 + 16.0))
    assert misfit(pairs, [1, 3], 16.0) == pytest.approx(0.5 * 9.0)


@pytest.mark.parametrize("axis", [0, 1], ids=["east", "north"])
def test_pairs_far_apart_are_not_compared(axis):
    """Five robots in one place and five boxes each 20 m farther on, of 4 m² together."""
    group = JointState(np.eye(COUNT))
    group.mean, group.rows = np.zeros(COUNT + 20), np.arange(5)
    group.covariance = 3.0 * np.eye(COUNT + 20)
    places = np.zeros((5, 2))
    places[:, axis] = 20.0 * np.arange(5)
    pairs = pair_innovations(
        group, places, np.zeros((5, 2, COUNT)), np.tile(np.eye(2), (5, 1, 1)), 100.0, 0.0
    )
    # Their trace is 8 m²: up to sqrt(800) = 28 m.
    assert set(pairs.columns.tolist()) == {0, 1}
    assert len(pairs.rows) == 10


def test_each_pair_together_with_others_is_as_uncertain_as_by_itself():
    rng = np.random.default_rng(3)
    group, places, by_errors = (
        _group(rng, 3),
        rng.normal(size=(4, 2)),
        rng.normal(size=(4, 2, COUNT)),
    )
    own, white = np.tile(0.1 * np.eye(2), (4, 1, 1)), np.tile(np.diag([0.5, 0.3]), (4, 1, 1))
    pairs = pair_innovations(group, places, by_errors, white, np.inf, np.inf)
    columns = pairs.columns
    found = joint_covariance(group, pairs.rows, by_errors[columns], white[columns], own[columns])
    blocks, every = found.reshape(12, 2, 12, 2), np.arange(12)
    np.testing.assert_allclose(blocks[every, :, every], pairs.spread, atol=1e-12)
    assert np.linalg.eigvalsh(found).min() > -1e-12


def test_what_moves_all_boxes_is_common_to_their_innovations():
    """Robots are known exactly, one error moves boxes east by 2 m, 1 m: of white noise, a part."""
    group = JointState(np.zeros((COUNT, COUNT)))
    group.covariance = np.zeros((COUNT + 8, COUNT + 8))
    group.covariance[0, 0] = 1.0
    group.mean, group.rows = np.zeros(COUNT + 8), np.arange(2)
    by_errors = np.zeros((2, 2, COUNT))
    by_errors[:, 0, 0] = 2.0, 1.0
    white = np.tile(np.diag([0.5, 0.3]), (2, 1, 1))
    own = np.tile(0.1 * np.eye(2), (2, 1, 1))
    found = joint_covariance(group, np.arange(2), by_errors, white, own)
    expected = [
        [4.5, 0.0, 2.4, 0.0], [0.0, 0.3, 0.0, 0.2],
        [2.4, 0.0, 1.5, 0.0], [0.0, 0.2, 0.0, 0.3],
    ]  # fmt: skip
    np.testing.assert_allclose(found, expected, atol=1e-12)
