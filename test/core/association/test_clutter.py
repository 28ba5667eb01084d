# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much false boxes in an image take away from what a box says."""

from __future__ import annotations

import math

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


@pytest.mark.parametrize(
    ("missed", "beside", "area", "doubtful"),
    [
        (50.0, 0.0, 1000.0, False),
        (0.5, 20.0, 100.0, False),
        (50.0, 20.0, 1.5, False),
        (50.0, 20.0, 3.0, True),
        (75.0, 20.0, 1.5, True),
    ],
    ids=["often missed", "clutter", "usual gate", "wide gate", "hardly seen"],
)
def test_a_box_in_a_wide_gate_may_be_clutter_of_a_robot_that_is_missed(
    missed, beside, area, doubtful
):
    """Of 100 robots: with half missed and a fifth beside clutter, 1 * 0.2 / 8 of a usual gate."""
    clutter, usual = Clutter(), math.log(0.3)
    clutter.update(0, 1e6, 1e4 * missed, 0, 1e4 * beside, [usual, usual])
    wide = np.array([usual + 2.0 * math.log(area)])
    assert clutter.doubtful(wide).tolist() == [doubtful]
    assert clutter.seen_share == pytest.approx(1.0 - 0.01 * missed, abs=1e-4)


def test_before_any_image_robots_are_mostly_seen_and_no_gate_is_doubtful():
    clutter = Clutter()
    assert clutter.seen_share == pytest.approx(0.95)
    assert not clutter.doubtful(np.array([-9.0, 0.0, 9.0])).any()


def test_old_images_fade():
    clutter = Clutter()
    clutter.update(0, 100, 100, 0)
    for stamp_ns in range(1, TUNING.fading_images + 1):
        clutter.update(stamp_ns, 1, 0, 0)
    old = 100.0 * math.exp(-1.0)
    every = sum(TUNING.prior_missed) + old + TUNING.fading_images * (1.0 - math.exp(-1.0))
    assert clutter.seen_share == pytest.approx(1.0 - (0.5 + old) / every, abs=1e-3)
