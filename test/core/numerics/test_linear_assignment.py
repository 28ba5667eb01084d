# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The assignment of least cost is scipy's, also where no search is made."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment as of_scipy

from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (3, 5), (5, 3), (4, 4), (0, 3), (3, 0)])
@pytest.mark.parametrize("favoured", [0.0, 10.0])
def test_it_is_scipys(shape: tuple[int, int], favoured: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        cost = rng.normal(size=shape)
        each = np.arange(min(shape))
        cost[each, rng.permutation(shape[1])[: len(each)]] -= favoured
        for whole in (cost, cost.round()):  # rounded: several are least
            found, expected = linear_sum_assignment(whole), of_scipy(whole)
            assert np.array_equal(found, expected)


@pytest.mark.parametrize("cost", [[[np.inf]], [[np.inf, np.inf], [0.0, 1.0]], [[np.nan, 0.0]]])
def test_costs_without_an_assignment_are_refused_as_by_scipy(cost: list[list[float]]) -> None:
    with pytest.raises(ValueError, match=r"infeasible|invalid numeric"):
        of_scipy(np.array(cost))
    with pytest.raises(ValueError, match=r"infeasible|invalid numeric"):
        linear_sum_assignment(np.array(cost))


def test_a_replay_of_boxes_imports_neither_the_search_nor_opencv() -> None:
    text = (
        "import sys, aerial_gnss_ros.cli, aerial_gnss_ros.commands.replay;"
        "print([name for name in ('scipy.optimize', 'cv2', 'matplotlib') if name in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", text], check=True, capture_output=True, text=True)
    assert found.stdout == "[]\n"
