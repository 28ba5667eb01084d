# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Formulas for numbers or arrays: an array operation costs as much as ten on numbers.

So a formula is evaluated robot by robot for few robots, and for all at once for many.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = Iterable[Any]
"""Rows of numbers, or one row of columns (n,): a formula accepts either."""

Formula = Callable[[Rows], list[tuple[Any, ...]]]
"""Takes rows of numbers, returns values for each."""

MAX_ROWS = 8
"""Greatest number of rows computed one by one."""


def all_finite(numbers: Array) -> bool:
    """Return whether a few numbers, of any shape, are all finite; less to call than `isfinite`."""
    return all(map(math.isfinite, numbers.ravel().tolist()))


def row_products(one: Array, other: Array) -> Array:
    """Return the scalar products (n,) of rows (n, k); with less overhead than einsum."""
    return (one[:, None, :] @ other[:, :, None]).reshape(-1)


def evaluate_rows(formula: Formula, given: Array, count: int) -> Array:
    """Return a formula's values (n, count) for rows (n, k) of numbers.

    Args:
        formula: accepts rows of k numbers, or one row of k arrays (n,), and returns `count` values
            for each. It is called once for all rows.
        given: (n, k).
        count: of the formula's values.
    """
    if 0 < len(given) <= MAX_ROWS:
        try:
            return np.array(formula(given.tolist()))
        except ZeroDivisionError:
            pass  # arrays handle division by zero
    table = np.empty((len(given), count))
    (columns,) = formula([given.T])
    for i, values in enumerate(columns):
        table[:, i] = values
    return table


def rowwise(*shape: int) -> Callable[[Formula], Callable[[Array], Array]]:
    """Return a decorator that lets a formula accept rows (n, k) and return (n, *shape).

    Args:
        shape: of the values of one row, which the formula returns as a flat tuple.
    """

    def decorated(formula: Formula) -> Callable[[Array], Array]:
        @wraps(formula)
        def evaluated(given: Array) -> Array:
            return evaluate_rows(formula, given, math.prod(shape)).reshape(-1, *shape)

        return evaluated

    return decorated
