# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two robots within a hull's length of one another: what tells whether they crossed."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.identity.pair_hypotheses import PairHypotheses

SIGMA = 0.08
"""Of a box's centre on the water, each axis, m."""


def _meet(seed, speeds, turn, within=4.0, thrown=(0.0, 0.0)):
    """Return the probability that two are exchanged; they meet head on at t = 0 and part.

    Args:
        seed: of the boxes' noise.
        speeds: of the two, m/s.
        turn: rad by which both turn to the left: 0 they cross, 3 they turn away.
        within: in so many s.
        thrown: East, North by which the platform throws all boxes to and fro, m.
    """
    rng = np.random.default_rng(seed)
    times = np.arange(-5.0, 5.0, 0.1)
    course = turn * np.clip(times / within + 0.5, 0.0, 1.0)
    steps = 0.1 * np.stack([np.cos(course), np.sin(course)], axis=1)
    path = np.cumsum(steps, axis=0)
    path -= path[np.argmin(np.abs(times))]
    ways = np.stack([speeds[0] * path, -speeds[1] * path + [0.0, 0.05]], axis=1)
    velocities = np.array([[speeds[0], 0.0], [-speeds[1], 0.0]])
    spread = np.tile(np.diag([0.05**2] * 4), (2, 1, 1))
    pair = PairHypotheses.begin(("a", "b"), ways[0], velocities, spread, 0)
    noise, shared = np.tile(SIGMA**2 * np.eye(2), (2, 1, 1)), 0.05**2 * np.eye(2)
    for i, places in enumerate(ways[1:], 1):
        seen = places + SIGMA * rng.standard_normal((2, 2)) + np.sin(times[i]) * np.array(thrown)
        pair.update(i * 100_000_000, seen, noise, shared, 0.1)
    return pair.exchanged


@pytest.mark.parametrize("turn", [0.0, 3.0])
def test_robots_of_different_speeds_are_told_apart_whether_they_cross_or_turn_away(turn):
    wrong = [_meet(seed, (0.3, 0.6), turn) for seed in range(5)]
    assert max(wrong) < 0.05


def test_robots_that_go_on_turning_are_told_apart_though_equally_fast():
    """Both by 86 degrees a second: had they crossed, both would have turned back at once."""
    wrong = [_meet(seed, (0.45, 0.45), 3.0, 2.0) for seed in range(5)]
    assert max(wrong) < 0.2


def test_a_platform_that_throws_both_boxes_about_changes_no_decision():
    for seed in range(3):
        assert _meet(seed, (0.3, 0.6), 3.0, thrown=(100.0, 50.0)) < 0.05
