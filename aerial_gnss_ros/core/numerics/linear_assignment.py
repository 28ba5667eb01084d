# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The assignment of least total cost, by scipy where it takes a search."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]


def linear_sum_assignment(cost: Array) -> Pairs:
    """Return rows, ascending, and columns of the assignment of least cost.

    Where each row has one least cost and no two have it in one column, these pairs are the only
    such assignment; otherwise `scipy.optimize.linear_sum_assignment` searches.

    Args:
        cost: (n, m) of each pair.

    Raises:
        ValueError: a cost is NaN, or there is no assignment of finite cost.
    """
    if 0 < cost.shape[0] <= cost.shape[1]:
        columns = cost.argmin(axis=1)
        least = cost.min(axis=1)
        alone = np.count_nonzero(cost <= least[:, None]) == len(columns)
        if alone and len({*columns.tolist()}) == len(columns) and np.isfinite(least).all():
            return np.arange(len(columns)), columns
    return solver()(cost)


def solver() -> Callable[[Array], Pairs]:
    """Import scipy's function: a tenth of a second, which many replays need not spend.

    A node calls this when it starts, so that it does not wait in flight.
    """
    from scipy.optimize import linear_sum_assignment as found

    solve: Callable[[Array], Pairs] = found
    return solve
