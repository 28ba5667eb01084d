# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A clock that was set is noticed by one that nobody sets."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.steady import Steady

SECOND = 1_000_000_000


@pytest.mark.parametrize(("rate", "found"), [(1.0, 3600), (0.9, 3600), (10.0, 0), (0.0, 0)])
def test_a_clock_that_was_set_is_noticed_by_a_steady_one(rate, found):
    """Where both went on alike before: simulated time may go faster."""
    steady = Steady()
    for i in range(100):
        assert steady.update(round(rate * i * SECOND / 10), i * SECOND // 10) == 0
    now = 100 * SECOND // 10
    by = steady.update(round(rate * now) + 3600 * SECOND, now)
    assert by == pytest.approx(found * SECOND, abs=SECOND)
    assert steady.since_s(now - SECOND) == (pytest.approx(1.0) if found else None)
    assert steady.update(round(rate * now) + 3600 * SECOND, now) == 0  # reported once


def test_without_a_steady_clock_nothing_is_known():
    steady = Steady()
    for i in range(100):
        assert steady.update(i * 100 * SECOND, None) == 0
    assert steady.since_s(0) is None


def test_a_pause_is_no_step():
    """The process stood still: both clocks went on."""
    steady = Steady()
    for t in [*range(10), 70, 71]:
        assert steady.update(t * SECOND, t * SECOND) == 0
