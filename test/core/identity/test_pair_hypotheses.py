# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two robots within a hull's length of one another: the evidence for whether they crossed."""

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
def test_robots_of_different_speeds_are_distinguished_whether_they_cross_or_turn_away(turn):
    wrong = [_meet(seed, (0.3, 0.6), turn) for seed in range(5)]
    assert max(wrong) < 0.05


def test_robots_that_go_on_turning_are_distinguished_though_equally_fast():
    """Both by 86 degrees a second: had they crossed, both would have turned back at once."""
    wrong = [_meet(seed, (0.45, 0.45), 3.0, 2.0) for seed in range(5)]
    assert max(wrong) < 0.2


def test_a_platform_that_throws_both_boxes_about_changes_no_decision():
    for seed in range(3):
        assert _meet(seed, (0.3, 0.6), 3.0, thrown=(100.0, 50.0)) < 0.05


@pytest.mark.parametrize(
    ("shift", "moved"), [(4.2, 2.1), (4.3, 0.20)], ids=["expected", "implausible"]
)
def test_a_common_displacement_beyond_three_sigmas_counts_as_noise(shift, moved):
    """Robots known to 2 m², boxes to 1 m² each and to 0.5 m² together.

    Their mean is expected to 0.5 (2 + 1) + 0.5 = 2 m²: three sigmas are 4.24 m. Half of the
    displacement is believed; beyond, 1 m² of 2 + 4.3² m².
    """
    places, eye = np.array([[0.0, 0.0], [3.0, 0.0]]), np.eye(2)
    pair = PairHypotheses.begin(
        ("a", "b"), places, np.zeros((2, 2)), np.tile(2.0 * np.eye(4), (2, 1, 1)), 0
    )
    pair.update(0, places + np.array([0.0, shift]), np.tile(eye, (2, 1, 1)), 0.5 * eye, 0.1)
    assert pair.states[0, [1, 5]] == pytest.approx([moved, moved], abs=0.01)


def test_hypotheses_are_merged_unless_they_label_the_boxes_differently():
    """Two robots in one place: no evidence exists, and two hypotheses represent all there is."""
    pair = PairHypotheses.begin(
        ("a", "b"), np.zeros((2, 2)), np.zeros((2, 2)), np.tile(0.1 * np.eye(4), (2, 1, 1)), 0
    )
    noise = np.tile(SIGMA**2 * np.eye(2), (2, 1, 1))
    for stamp_ns in (100_000_000, 200_000_000):
        pair.update(stamp_ns, np.zeros((2, 2)), noise, 0.01 * np.eye(2), 0.1)
        assert sorted(pair.signs) == [-1.0, 1.0]
        assert pair.exchanged == pytest.approx(0.5)


def test_what_the_picture_says_of_an_exchange_counts_as_odds():
    """Both boxes are in the middle between the two: only the picture tells which is which."""
    spread = np.tile(np.diag([0.05**2] * 4), (2, 1, 1))
    own, common = np.tile(SIGMA**2 * np.eye(2), (2, 1, 1)), 0.05**2 * np.eye(2)
    ways = np.array([[-0.05, 0.0], [0.05, 0.0]])
    for odds, probability in ((9.0, 0.9), (0.25, 0.2)):
        pair = PairHypotheses.begin(("a", "b"), ways, np.zeros((2, 2)), spread, 0)
        seen = np.zeros((2, 2))
        changed = pair.update(100_000_000, seen, own, common, 0.1, np.log(odds))
        assert changed == pytest.approx(probability)
        assert pair.exchanged == pytest.approx(probability)
        again = pair.update(200_000_000, seen, own, common, 0.1, -100.0)
        assert again == pytest.approx(0.0, abs=1e-9)
        assert pair.exchanged == pytest.approx(probability, abs=0.01)
