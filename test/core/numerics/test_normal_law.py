# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The normal law's distribution function, against scipy's."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from aerial_gnss_ros.core.numerics.normal_law import normal_share


def test_it_is_that_of_scipy_also_in_both_tails():
    limits = np.concatenate([np.linspace(-30.0, 10.0, 39), [-np.inf, np.inf, np.nan]])
    table = limits.reshape(3, 2, 7)
    np.testing.assert_allclose(normal_share(table), ndtr(table), rtol=1e-13)


def test_of_no_limits_there_are_no_shares():
    assert normal_share(np.zeros((2, 0, 3))).shape == (2, 0, 3)
