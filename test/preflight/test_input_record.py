# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is counted of an input before a flight."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.preflight.input_record import InputRecord

SECOND = 1_000_000_000


@pytest.mark.parametrize(
    ("count", "last_s", "rate"), [(0, 5, 0.0), (1, 5, 0.0), (11, 6, 2.0), (2, 1, 0.0)]
)
def test_a_rate_is_that_of_the_intervals(count, last_s, rate):
    record = InputRecord(count, first_arrival_ns=SECOND, last_arrival_ns=last_s * SECOND)
    assert record.rate == pytest.approx(rate)


def test_a_delay_is_the_median_of_the_newest():
    record = InputRecord()
    assert record.delay_s == 0.0
    record.delays_ns.extend([9 * SECOND] * 600 + [SECOND // 10] * 300)
    assert record.delay_s == pytest.approx(0.1)  # of 500, most are newer
    record.delays_ns.extend([SECOND // 5, SECOND, SECOND // 2] * 200)
    assert record.delay_s == pytest.approx(0.5)


def test_a_refusal_can_be_taken_back():
    record = InputRecord()
    record.refuse("one")
    record.refuse("other")
    record.undo_refusal()
    assert (record.bad, record.trouble) == (1, "other")
    record.undo_refusal()
    assert (record.bad, record.trouble) == (0, "")
