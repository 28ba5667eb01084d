# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stamps are shifted on their way in and back on their way out."""

from __future__ import annotations

from dataclasses import replace

import pytest

from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.values.rejection import Reason, Rejection
from aerial_gnss_ros.core.values.samples import Scalar


def test_what_came_before_a_step_keeps_its_stamp(result_at):
    base = TimeBase()
    value, result = Scalar(7, 1.0), result_at(7, ["a"])
    assert base.shifted(value) is value
    assert base.stamped(result) is result
    base.step(100, last_ns=10)
    assert base.shifted(Scalar(111, 1.0)) == Scalar(11, 1.0)
    assert base.of(111) == 11
    late = (Rejection(10, Reason.GATED, 1.0, 2.0), Rejection(11, Reason.GATED, 1.0, 2.0))
    stamped = base.stamped(replace(result_at(12, ["a"]), late=late, rejections=late[1:]))
    assert [one.stamp_ns for one in stamped.late] == [10, 111]
    assert [one.stamp_ns for one in stamped.rejections] == [111]
    assert (stamped.stamp_ns, stamped.pose.stamp_ns) == (112, 112)
    assert (stamped.estimates[0].stamp_ns, stamped.estimates[0].last_seen_ns) == (112, 111)
    base.step(-130, last_ns=20)
    assert base.of(-9) == 21
    assert [one.stamp_ns for one in base.refused(late)] == [10, 111]


def test_steps_of_long_ago_are_forgotten():
    base = TimeBase()
    for i in range(100):
        base.step(5, last_ns=10 * i)
    assert base.shift_ns == -500
    assert base.refused((Rejection(991, Reason.GATED, 0.0, 0.0),))[0].stamp_ns == 1491


@pytest.mark.parametrize(
    ("timed", "stepped", "passed_s", "last_ns", "first_ns", "expected"),
    [
        (True, False, None, 500, 10**12, 9 * 10**9),  # the node's clock shows the time that passed
        (False, True, 2.0, 500, 10**12, 7 * 10**9),  # a steady one does
        (False, True, None, 500, 10**12, None),
        (False, False, 2.0, 500, 10**12, None),
        (True, False, None, None, 10**12, None),  # no image before it
        (True, False, None, 500, 10_000, 9_599),  # the next image is at least 1 ns later
    ],
)
def test_a_step_is_what_stamps_moved_beyond_the_time_that_passed(
    timed, stepped, passed_s, last_ns, first_ns, expected
):
    base = TimeBase()
    base.step(-100, last_ns=0)  # times are 100 ns after stamps
    decision = Decision(
        True, ("fix",), by_ns=9 * 10**9, first_ns=first_ns, timed=timed, stepped=stepped
    )
    assert base.step_ns(decision, passed_s, last_ns) == expected
