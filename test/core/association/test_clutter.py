# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much false boxes in an image take away from what a box says."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.clutter import TUNING, Clutter, chance_probability


@pytest.mark.parametrize(
    ("beside", "tracks", "share"),
    [(0, 100, 0.0), (0, 0, 0.0), (9, 1, 0.632), (9, 10, 0.0952), (2700, 300, 0.632)],
)
def test_the_chance_of_a_false_box_in_a_gate(beside, tracks, share):
    """Boxes within three times the gate are in it by 1/9 each: 1 - exp(-expected number)."""
    assert chance_probability(beside, tracks) == pytest.approx(share, abs=1e-3)


def test_clutter_is_heavy_where_boxes_are_missed_and_false_too_often_to_be_by_chance():
    """Product of the two rates, each faded image by image, against the definition."""
    rng, reported = np.random.default_rng(4), set()
    for share in (0.5, 1.0, 2.0):
        clutter, seen = Clutter(), []
        rate = share * np.sqrt(TUNING.rare_product)
        for stamp_ns in range(400):
            robots = int(rng.integers(1, 9))
            seen.append((1, robots, rng.binomial(robots, rate), rng.poisson(rate)))
            clutter.update(stamp_ns, robots, seen[-1][2], seen[-1][3])
            fading = (1.0 - 1.0 / TUNING.fading_images) ** np.arange(len(seen))[::-1]
            images, all_robots, missed, stray = fading @ np.array(seen)
            rates = missed / all_robots, stray / images
            assert clutter.heavy == (rates[0] * rates[1] > TUNING.rare_product)
            reported.add(clutter.heavy)
    assert reported == {True, False}
