# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which robots begin a law in which some are moored."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from aerial_gnss_ros.core.filter.moored_candidates import likely_still, most_alike
from aerial_gnss_ros.core.filter.moored_law import MooredLaw

sys.path.insert(0, str(Path(__file__).parent))

from swimming_robots import swimming


def test_rounding_does_not_choose_between_two_that_drift_alike():
    base, rng = swimming((0.2, 0.0), (0.5, -0.4), (0.21, 0.0)), np.random.default_rng(0)
    for _ in range(30):
        base.covariance += 1e-12 * rng.standard_normal(base.covariance.shape)
        assert most_alike(base, [0, 1, 2], 1.0) == 0


def test_robots_alike_go_together_and_one_that_swims_does_not():
    base = swimming((0.21, 0.0), (0.5, -0.4), (0.2, 0.01), (0.19, 0.0))
    first = most_alike(base, [0, 1, 2, 3], 1.0)
    assert first in (0, 2, 3)
    law = MooredLaw.of(base, adrift=True)
    law.moor(first)
    for slot in {0, 2, 3} - {first}:
        assert law.odds([slot])[0] > 3.0
    assert law.odds([1])[0] < -10.0
    assert most_alike(swimming((0.5, 0.0)), [0], 1.0) == -1


def test_those_that_stay_are_distinguished_from_those_that_swim():
    base = swimming((0.01, 0.0), (0.5, -0.4), (0.0, -0.02))
    assert likely_still(base, [0, 1, 2], 1.0) == [0, 2]
    assert likely_still(base, [1, 2], 1.0) == [2]
