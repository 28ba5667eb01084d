# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The usual step follows the steps, and a conspicuous one is several times that."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.numerics.usual_step import UsualStep


@pytest.mark.parametrize(("step", "allowed", "odd"), [
    (9.9, 0.0, False), (10.1, 0.0, True), (10.1, 0.2, False), (12.1, 2.0, True),
])  # fmt: skip
def test_before_the_first_step_the_given_one_is_usual(step, allowed, odd):
    assert UsualStep(2.0).is_odd(step, allowed) is odd


def test_the_first_one_counts_as_one_step():
    """2 m at first, 1 m three times: (4 + 3) / 4, as nothing is forgotten in no time."""
    usual = UsualStep(2.0)
    for _ in range(3):
        usual.update(1.0, 0.0)
    limit = 5.0 * math.sqrt(7.0 / 4.0)
    assert not usual.is_odd(limit - 1e-6, 0.0)
    assert usual.is_odd(limit + 1e-6, 0.0)


def test_it_forgets_within_seconds():
    """2 m for long, 1 m for 5 s: 1 + (4 - 1) / e of the square is left."""
    usual = UsualStep(2.0)
    for step in (2.0,) * 1000 + (1.0,) * 50:
        usual.update(step, 0.1)
    limit = 5.0 * math.sqrt(1.0 + 3.0 / math.e)
    assert not usual.is_odd(limit - 1e-6, 0.0)
    assert usual.is_odd(limit + 1e-6, 0.0)


def test_ten_seconds_of_small_steps_show_a_jump_of_a_metre():
    usual = UsualStep(2.0)
    for _ in range(100):
        usual.update(0.1, 0.1)
    assert usual.is_odd(1.0, 0.05)
