# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Contiguous columns of a table, for bit-reproducible results of numpy's functions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def columns(table: Array) -> Array:
    """Return the columns of a table (n, k) as rows (k, n) that are contiguous in memory.

    numpy 1.26 (Ubuntu 24.04) computes arctan2, arcsin, exp, log and others with AVX-512, but falls
    back to the C library, which rounds the last bit differently, if it believes that output and
    input overlap. It takes a column of a table to extend up to a row beyond the table, where the
    output may happen to be.
    """
    return np.ascontiguousarray(table.T)
