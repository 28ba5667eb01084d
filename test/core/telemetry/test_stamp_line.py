# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which stamps go on from one another: the bounds of each rule, to a nanosecond."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.stamp_line import (
    AHEAD_NS,
    DRIFT_NS,
    EARLY_NS,
    LATE_NS,
    Line,
)

SECOND = 1_000_000_000


def _line(offset_ns=None):
    """Return a line at 101 s that came every second; the node's clock is behind by an offset."""
    line = Line(100 * SECOND, 100 * SECOND)
    line.add(101 * SECOND)
    if offset_ns is not None:
        line.note_arrival(101 * SECOND - offset_ns)
    return line


@pytest.mark.parametrize(
    ("stamp_ns", "goes_on"),
    [
        (101 * SECOND - LATE_NS, True),
        (101 * SECOND - LATE_NS - 1, False),
        (101 * SECOND + AHEAD_NS, True),
        (101 * SECOND + AHEAD_NS + 1, False),
    ],
)
def test_without_a_clock_a_stamp_may_be_late_or_ahead_by_seconds(stamp_ns, goes_on):
    assert _line().goes_on(stamp_ns, None) is goes_on
    assert _line().goes_on(stamp_ns, 50 * SECOND) is goes_on  # nothing was reported yet
    assert _line(0).goes_on(stamp_ns, None) is goes_on


def test_with_a_clock_a_stamp_may_be_ahead_of_it_as_others_were():
    line, now_ns = _line(3 * SECOND), 108 * SECOND
    latest = now_ns + 3 * SECOND + EARLY_NS
    assert line.goes_on(latest, now_ns)
    assert not line.goes_on(latest + 1, now_ns)


def test_stamps_as_far_apart_as_they_were_are_not_early():
    line = _line(0)
    stalled_ns = 90 * SECOND  # whatever the clock says
    latest = 101 * SECOND + SECOND + EARLY_NS
    assert not line.is_behind(latest, stalled_ns)
    assert line.is_behind(latest + 1, stalled_ns)
    slow = Line(0, 0)
    slow.add(5 * SECOND)
    slow.note_arrival(5 * SECOND)
    assert not slow.is_behind(5 * SECOND + AHEAD_NS, 0)
    assert slow.is_behind(5 * SECOND + AHEAD_NS + 1, 0)


@pytest.mark.parametrize("now_s", [99, 104])
def test_a_line_leads_another_by_no_more_than_is_far_off(now_s):
    line, now_ns = _line(0), now_s * SECOND
    latest = max(101 * SECOND, now_ns) + AHEAD_NS
    assert line.is_led(latest, now_ns)
    assert not line.is_led(latest + 1, now_ns)
    assert line.is_led(101 * SECOND, now_ns)
    assert not line.is_led(101 * SECOND - 1, now_ns)
    assert not line.is_led(latest, None)
    assert not _line().is_led(101 * SECOND, now_ns)


def test_only_a_newer_stamp_moves_it_on():
    line = _line(0)
    line.add(100 * SECOND)
    assert (line.newest_ns, line.step_ns, line.count) == (101 * SECOND, SECOND, 2)
    line.add(101 * SECOND)
    assert line.told_ns is not None
    line.add(103 * SECOND)
    assert (line.newest_ns, line.step_ns, line.count) == (103 * SECOND, 2 * SECOND, 4)
    assert line.told_ns is None
    assert line.span_s == 3.0


def test_the_offset_is_the_largest_until_the_clock_is_set():
    line = _line(0)
    for stamp_s, now_ns, offset_ns in (
        (102, 102 * SECOND + 7, 0),  # came late
        (103, 103 * SECOND - 5, 5),
        (104, 104 * SECOND - 5 + DRIFT_NS, 5),
        (105, 105 * SECOND - 4 + DRIFT_NS, 4 - DRIFT_NS),  # was set
    ):
        line.add(stamp_s * SECOND)
        line.note_arrival(now_ns)
        assert line.offset_ns == offset_ns


def test_of_several_stamps_the_newest_tells_and_once():
    line = _line(0)
    line.add(104 * SECOND)
    line.add(103 * SECOND)
    assert line.heard
    line.note_arrival(102 * SECOND)
    assert line.offset_ns == 2 * SECOND
    line.note_arrival(50 * SECOND)  # nothing came since
    assert line.offset_ns == 2 * SECOND


def test_what_would_come_now_is_as_long_after_the_newest_as_has_passed():
    line = _line(SECOND)  # reported at 100 s
    assert line.expected_ns(100 * SECOND + 7) == 101 * SECOND + 7
    assert line.expected_ns(90 * SECOND) == 101 * SECOND
    assert line.expected_ns(None) == 101 * SECOND
    assert _line().expected_ns(100 * SECOND + 7) == 101 * SECOND
    assert (line.told_ns, line.begun_ns) == (100 * SECOND, 100 * SECOND)
    line.note_arrival(105 * SECOND)
    assert (line.told_ns, line.begun_ns) == (100 * SECOND, 100 * SECOND)


def test_a_line_is_heard_once_a_stamp_came():
    line = Line(0, 0)
    assert not line.heard
    line.add(0)
    assert line.heard
    line.note_arrival(0)
    assert line.heard
