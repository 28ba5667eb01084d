# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""People are drawn as large as asked, in colours of people, and differ."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.training.people import person


@pytest.mark.parametrize("length", [12.0, 40.0, 110.0])
def test_a_person_is_about_as_long_as_asked_and_inside_its_square(length):
    longest = []
    for seed in range(12):
        share, colours = person(np.random.default_rng(seed), length)
        assert (*share.shape, 3) == colours.shape
        assert 0.0 <= share.min() <= share.max() <= 1.0 + 1e-6
        assert 0.0 <= colours.min() <= colours.max() <= 255.0
        rows, columns = np.nonzero(share > 0.3)
        longest.append(max(np.ptp(rows), np.ptp(columns)))
    assert 0.3 * length < np.median(longest) < 1.3 * length


def test_same_seed_same_person_and_others_differ():
    one, same, other = (person(np.random.default_rng(seed), 40.0) for seed in (1, 1, 2))
    assert all(np.array_equal(a, b) for a, b in zip(one, same, strict=True))
    assert not np.array_equal(one[0], other[0])


def test_about_half_wear_a_rescue_colour():
    bright = 0
    for seed in range(60):
        share, colours = person(np.random.default_rng(seed), 60.0)
        red, blue = colours[..., 2], colours[..., 0]
        bright += int(((red > 150) & (blue < 70) & (share > 0.9)).sum() > 30)
    assert 15 < bright < 50
