# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Columns of a table for numpy's functions, so that equal input gives equal bytes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def columns(table: Array) -> Array:
    """Return the columns of a table (n, k) as rows (k, n) that are contiguous in memory.

    numpy 1.26 (Ubuntu 24.04) computes arctan2, arcsin, exp, log and others with AVX-512, but leaves
    it for the C library, which rounds the last bit otherwise, where it takes output and input to
    overlap. It takes a column of a table to end up to a row behind the table, where the output
    comes to lie by chance.
    """
    return np.ascontiguousarray(table.T)
