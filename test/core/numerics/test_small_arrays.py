# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Few rows and many give the same, and one by zero stops nothing."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.numerics.small_arrays import (
    MAX_ROWS,
    evaluate_rows,
    row_products,
    rowwise,
)


def _formula(rows):
    return [(x * y, 1.0, x / y) for x, y in rows]


def test_few_rows_give_what_they_give_among_many():
    rows = np.random.default_rng(1).normal(size=(MAX_ROWS + 5, 2))
    many = evaluate_rows(_formula, rows, 3)
    assert evaluate_rows(_formula, rows[:MAX_ROWS], 3) == pytest.approx(many[:MAX_ROWS], rel=1e-15)
    assert evaluate_rows(_formula, rows[:0], 3).shape == (0, 3)


def test_one_by_zero_is_infinite_for_few_rows_too():
    with np.errstate(divide="ignore"):
        assert evaluate_rows(_formula, np.array([[1.0, 0.0]]), 3).tolist() == [[0.0, 1.0, np.inf]]


def test_a_decorated_formula_gives_a_matrix_for_each_row():
    @rowwise(2, 2)
    def turned(rows):
        return [(c, -s, s, c) for c, s in rows]

    assert turned(np.array([[1.0, 2.0]])).tolist() == [[[1.0, -2.0], [2.0, 1.0]]]
    assert turned(np.ones((3 * MAX_ROWS, 2))).shape == (3 * MAX_ROWS, 2, 2)


def test_products_of_rows():
    assert row_products(
        np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[5.0, 6.0], [7.0, 8.0]])
    ).tolist() == [17.0, 53.0]
