# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much false boxes in an image take away from what a box says."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.association.clutter import chance_probability


@pytest.mark.parametrize(
    ("beside", "tracks", "share"),
    [(0, 100, 0.0), (0, 0, 0.0), (9, 1, 0.632), (9, 10, 0.0952), (2700, 300, 0.632)],
)
def test_the_chance_of_a_false_box_in_a_gate(beside, tracks, share):
    """Boxes within three times the gate are in it by 1/9 each: 1 - exp(-expected number)."""
    assert chance_probability(beside, tracks) == pytest.approx(share, abs=1e-3)
