# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Formulas that take numbers or arrays: an operation on an array costs as much as on ten numbers.

So what there is for each of a few robots is computed robot by robot, and by the same formula for
all at once where they are many.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = Iterable[Any]
"""Rows of numbers, or one row of columns (n,) of all of them: a formula takes either."""

MAX_ROWS = 8
"""Up to so many rows are computed one by one."""


def all_finite(numbers: Array) -> bool:
    """Return whether a few numbers, of any shape, are all finite; less to call than `isfinite`."""
    return all(map(math.isfinite, numbers.ravel().tolist()))


def row_products(one: Array, other: Array) -> Array:
    """Return the scalar products (n,) of rows (n, k); less to call than einsum."""
    return (one[:, None, :] @ other[:, :, None]).reshape(-1)


def evaluate_rows(
    formula: Callable[[Rows], list[tuple[Any, ...]]], given: Array, count: int
) -> Array:
    """Return what a formula makes of rows (n, k) of numbers, (n, count).

    Args:
        formula: takes rows of k numbers, or one row of k arrays (n,); returns `count` values for
            each. It goes through all rows in one call.
        given: (n, k).
        count: of the formula's values.
    """
    if 0 < len(given) <= MAX_ROWS:
        try:
            return np.array(formula(given.tolist()))
        except ZeroDivisionError:
            pass  # arrays know what one by zero is
    table = np.empty((len(given), count))
    (columns,) = formula([given.T])
    for i, values in enumerate(columns):
        table[:, i] = values
    return table
