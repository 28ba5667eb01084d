# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is sent again until the next value is measured is no measurement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.telemetry.held_values import TUNING, HeldValues, repeats, without_repeated
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar


def fix(t, value):
    return Fix(round(t * 1e9), 0.2 + 1e-9 * value, -1.0, math.nan)


def dropped(values, every_s=0.25, runs=TUNING.positions):
    """Return which of some positions, sent in turn, are no measurements."""
    held, found, last = HeldValues(runs), [], fix(-1e9, -1)
    for k, one in enumerate(values):
        sample = fix(k * every_s, one)
        held.update(sample)
        found.append(repeats(last, sample, held.held_s))
        last = last if found[-1] else sample
    return found


def test_positions_that_are_sent_four_times_each():
    """The first three decide, from the fourth on."""
    found = dropped([k // 4 for k in range(24)])
    assert found == [k >= 12 and k % 4 > 0 for k in range(24)]


def test_ten_a_second_of_which_six_are_new():
    values = [0, 1, 1, 2, 3, 3, 4, 4, 5, 6, 6]
    assert dropped(values, 0.1) == [False] * 7 + [True, False, False, True]


@pytest.mark.parametrize(
    "values",
    [
        range(40),
        [0] * 40,  # a mast, or a simulator without noise
        [*([0] * 30), *range(1, 30)],  # it stands, then flies
        [0, 0, 0, 0, 0, 1, 2, 2, 3, 3, 3, 3, 3, 3, 4, 5, 5, 5, 5, 5, 5],  # it rounds
        [0, 0, 1, 1, 2, 2, 1, 1, 2, 2, 0, 0, 3, 3, 1, 1, 4, 4, 0, 0],  # it rounds, and stands
    ],
    ids=["new ones", "constant", "starts", "rounded", "comes back"],
)
def test_positions_that_are_measured_each_time(values):
    assert not any(dropped(values))


def test_other_values_have_to_be_repeated_more_often():
    found = dropped([k // 2 for k in range(40)], runs=TUNING.values)
    assert found == [k >= 2 * TUNING.values and k % 2 > 0 for k in range(40)]
    longer = [0, 0, 0, 0, 0, *(k // 2 for k in range(2, 22))]
    assert not any(dropped(longer, runs=TUNING.values))


def test_a_drone_that_stops_is_measured_again_after_one_and_a_half_times_as_long():
    found = dropped([k // 4 for k in range(16)] + [4] * 13)
    assert [k for k, one in enumerate(found) if k >= 16 and not one] == [16, 22, 28]


def test_one_position_that_comes_late_changes_nothing_and_new_ones_end_it():
    found = dropped([k // 4 for k in range(16)] + [4] * 6 + [5] * 4 + [6, 7, 8, 9, 9])
    assert found[16:26] == [False, *([True] * 5), False, *([True] * 3)]
    assert found[26:] == [False] * 5


@pytest.mark.parametrize(
    "sample",
    [
        lambda ns, value=20.0: Scalar(ns, value),
        lambda ns, value=1.0: Orientation(ns, np.array([0.0, 0.0, 0.0, value])),
        lambda ns, value=7.0: Fix(ns, 0.2, value, math.nan),
    ],
    ids=["height", "gimbal", "fix"],
)
def test_a_value_is_repeated_within_that_time_by_a_later_sample(sample):
    held = HeldValues(TUNING.positions)
    first, within, at = 10**18, 10**18 + 1_400_000_000, 10**18 + 1_500_000_000
    assert not repeats(sample(first), sample(within), held.held_s)
    for k in range(13):
        held.update(fix(0.25 * k, k // 4))
    assert held.held_s == 1.5
    assert repeats(sample(first), sample(within), held.held_s)
    assert not repeats(sample(first), sample(at), held.held_s)
    assert not repeats(sample(within), sample(first), held.held_s)
    assert not repeats(sample(first), sample(within, 0.5), held.held_s)
    held.update(fix(0.0, 9))  # older: says nothing
    assert held.held_s == 1.5
    held.clear()
    assert held.held_s == 0.0


def test_samples_that_repeat_the_last_one_kept_are_left_out():
    samples = [Scalar(k * 10**9, value) for k, value in enumerate([5.0, 5.0, 6.0, 6.0, 6.0, 5.0])]
    kept = without_repeated(samples, 1.5)
    assert [one.stamp_ns // 10**9 for one in kept] == [0, 2, 4, 5]
    assert without_repeated(samples, 0.0) == samples
