# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stamps are shifted on their way in and back on their way out."""

from __future__ import annotations

from dataclasses import replace

from aerial_gnss_ros.core.estimation.time_base import TimeBase
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
