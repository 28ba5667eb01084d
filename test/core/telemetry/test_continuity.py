# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Samples that cannot follow one another: which of them are believed."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.telemetry.continuity import Continuity

STEP, SPEED, SETTLE_S = 5.0, 20.0, 10.0


def apart(one, other):
    return abs(one - other)


def continuity(**values):
    return Continuity(apart, STEP, SPEED, SETTLE_S, **values)


def take(judge, values, begin=0.0, rate=10.0):
    """Return which of values, so many a second, are believed."""
    return [
        judge.update(round((begin + i / rate) * 1e9), value).accepted
        for i, value in enumerate(values)
    ]


def level(value, seconds, rate=10):
    """Values that vary a little, as measured ones do."""
    return [value + 0.01 * (i % 3) for i in range(round(seconds * rate))]


@pytest.mark.parametrize(("jump", "believed"), [(6.9, True), (7.1, False), (-7.1, False)])
def test_a_sample_is_believed_as_far_as_step_and_speed_allow(jump, believed):
    judge = continuity()
    assert take(judge, [20.0, 20.0 + jump]) == [True, believed]  # 5 m + 20 m/s for 0.1 s


def test_an_outlier_and_a_burst_are_refused_and_what_was_goes_on():
    judge = continuity()
    values = [*level(20.0, 4.0), 1e6, *level(20.0, 1.0), *level(1.0, 3.5), *level(20.0, 1.0)]
    believed = take(judge, values)
    assert [value for value, good in zip(values, believed, strict=True) if not good] == [
        1e6, *level(1.0, 3.5),
    ]  # fmt: skip


@pytest.mark.parametrize(("before_s", "needed_s"), [(0.5, 3.0), (6.0, 6.0), (30.0, SETTLE_S)])
def test_the_new_course_is_believed_when_it_outlasts_the_old_one(before_s, needed_s):
    judge = continuity()
    take(judge, level(20.0, before_s))
    believed = take(judge, level(60.0, 20.0), begin=before_s)
    assert believed.index(True) * 0.1 == pytest.approx(needed_s, abs=0.15)
    assert all(believed[believed.index(True) :])


def test_a_wrong_level_is_not_believed_because_it_could_have_been_reached_by_now():
    judge = Continuity(apart, STEP, SPEED, settle_s=1e9)
    take(judge, level(20.0, 60.0))
    assert not any(take(judge, level(120.0, 30.0), begin=60.0))  # 5 s at 20 m/s
    assert all(take(judge, level(21.0, 1.0), begin=90.0))


def test_courses_that_take_turns_do_not_add_up():
    judge = continuity()
    take(judge, level(20.0, 5.0))
    mixed = [
        value for pair in zip(level(20.0, 20.0), level(60.0, 20.0), strict=True) for value in pair
    ]
    assert take(judge, mixed, begin=5.0, rate=20.0) == [True, False] * 200


def test_what_was_silent_may_be_elsewhere():
    judge = continuity()
    take(judge, level(20.0, 5.0))
    assert take(judge, [100.0], begin=10.0) == [True]
    assert take(judge, [400.0], begin=11.0) == [False]


def test_a_frozen_value_says_nothing_of_where_the_platform_is_now():
    values = [0.0] * 30 + [50.0]  # 3 s frozen
    assert take(continuity(), values)[-1] is False
    assert take(continuity(frozen_s=10.0), values)[-1] is True
    assert take(continuity(frozen_s=1.0), values)[-1] is False


def test_it_says_nothing_for_as_long_as_it_was_frozen():
    assert take(continuity(frozen_s=10.0), [0.0] * 11 + [26.9])[-1] is True  # 1 s, and 0.1 s
    assert take(continuity(frozen_s=10.0), [0.0] * 11 + [27.1])[-1] is False


def test_a_verdict_tells_how_far_and_how_soon():
    judge = continuity()
    take(judge, [20.0, 20.0])
    verdict = judge.update(round(0.35e9), 62.5)
    assert (verdict.distance, verdict.elapsed_s) == pytest.approx((42.5, 0.25))
    assert not verdict.accepted
    assert not verdict.replaced


def test_a_new_course_of_one_exact_value_is_never_believed_where_it_must_vary():
    judge = continuity(must_vary=True)
    take(judge, level(20.0, 5.0))
    assert not any(take(judge, [0.3] * 400, begin=5.0))
    other = continuity(must_vary=True)
    take(other, level(20.0, 5.0))
    assert take(other, level(60.0, 12.0), begin=5.0)[-1]


def test_late_samples_and_repeated_stamps_count_for_no_time():
    judge = continuity()
    take(judge, level(20.0, 1.0))
    assert not any(judge.update(round(1e9), 60.0 + 0.01 * i).accepted for i in range(100))
    assert judge.update(round(0.5e9), 20.0).accepted


def test_memory_is_bounded():
    judge = continuity()
    take(judge, level(20.0, 1.0))
    assert not any(take(judge, [1e3 * (i + 1) for i in range(1000)], begin=1.0))
    assert len(judge._runs) == 4
    assert all(take(judge, level(20.0, 1.0), begin=101.0))


def test_after_clear_the_next_sample_is_believed():
    judge = continuity()
    take(judge, level(20.0, 5.0))
    judge.clear()
    assert take(judge, level(60.0, 1.0), begin=0.0) == [True] * 10
    assert judge.lasted_s == pytest.approx(0.9)


@pytest.mark.parametrize("jump", [5.3, 5.6, 8.0, 12.0, -8.0])
@pytest.mark.parametrize("burst", [1, 20])
def test_noise_does_not_tell_for_a_course_that_is_over(jump, burst):
    """A range finder over a boat for a second; messages without stamps come in bursts, too."""
    judge, replaced, refused = continuity(must_vary=True), 0, []
    for i in range(60 * 50):
        second = i / 50
        value = 15.0 + 0.3 * math.sin(second) + 0.05 * math.sin(7.3 * i)
        value += jump if 20.0 <= second < 21.0 else 0.0
        stamp_s = (i // burst * burst) / 50 + (i % burst) * 1e-4 if burst > 1 else second
        verdict = judge.update(round(stamp_s * 1e9), value)
        replaced += verdict.replaced
        refused += [] if verdict.accepted else [second]
    assert replaced <= 1
    assert all(20.0 <= second < 21.0 + SETTLE_S + 0.5 for second in refused)
