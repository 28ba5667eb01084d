# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Columns whose functions do not depend on what lies where in memory."""

import numpy as np

from aerial_gnss_ros.core.numerics.columns import columns


def test_a_function_of_columns_is_the_same_wherever_its_output_lies():
    n = 300
    memory = np.empty(4 * n + 100)
    table = memory[: 3 * n].reshape(n, 3)
    table[:] = np.random.default_rng(1).uniform(0.1, 0.9, (n, 3))
    x, _, z = columns(table)
    for function in (np.arctan2, np.power):
        expected = function(z, x)
        for gap in range(4):
            out = memory[3 * n + gap : 4 * n + gap]  # a view of table gave other bits here
            np.testing.assert_array_equal(function(z, x, out=out), expected)
