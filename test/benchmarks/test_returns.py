# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Probabilities of returning robots are honest."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import returns


@pytest.mark.parametrize("kind", ["white", "steady"])
def test_as_many_names_are_right_as_their_probabilities_say(kind):
    drawn = [returns.probability(kind, seed) for seed in range(100)]
    found = [one for one in drawn if one is not None]
    expected = sum(p for p, _ in found)
    deviation = math.sqrt(sum(p * (1.0 - p) for p, _ in found))
    assert len(found) == 100
    assert abs(sum(right for _, right in found) - expected) < 3.0 * deviation
