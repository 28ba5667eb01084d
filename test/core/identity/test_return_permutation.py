# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that have all surfaced: positions and the order of their absences identify them."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.identity.return_permutation import likeliest_permutation
from aerial_gnss_ros.core.identity.return_time import AbsenceTimes

ROWS = np.arange(3)


def _order(cost, gone):
    possible = np.ones((3, 3), dtype=bool)
    law = AbsenceTimes(180.0)
    return likeliest_permutation(np.array(cost), possible, ROWS, ROWS, np.array(gone), law)


def test_places_decide_where_absences_are_alike():
    """Of costs that differ by 2 log 4, the worse way has a fifth."""
    cost = np.full((3, 3), 100.0)
    cost[0, 0] = cost[1, 1] = cost[2, 2] = 0.0
    cost[0, 1] = cost[1, 0] = np.log(4.0)
    rows, chances = _order(cost, np.full((3, 3), 60.0))
    assert rows.tolist() == [0, 1, 2]
    assert chances[0] == pytest.approx([0.8, 0.2, 0.0], abs=1e-6)


def test_robots_that_dived_in_turn_come_up_in_turn():
    """Down at 0, 5 and 10 s, up at 60, 65 and 70 s; places say nothing."""
    gone = np.array([60.0, 65.0, 70.0]) - np.array([0.0, 5.0, 10.0])[:, None]
    rows, chances = _order(np.zeros((3, 3)), gone)
    assert rows.tolist() == [0, 1, 2]
    assert chances.diagonal().min() > 0.9
