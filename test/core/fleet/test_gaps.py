# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sequence numbers in any order, with losses: what is new, what is asked for, what is lost."""

from __future__ import annotations

import math
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.fleet.gaps import Gaps
from aerial_gnss_ros.core.fleet.outbox import TUNING, SentSighting

LATER = count(10**12, 10**12)  # so late that all is asked for again


def sent(number, oldest=0, session=5):
    return SentSighting("a", session, number, oldest, None)


def taken(gaps, *numbers, oldest=0):
    return [gaps.take(sent(number, oldest)) for number in numbers]


def test_what_is_missing_between_sightings_is_wanted_until_it_arrives_or_is_given_up():
    gaps = Gaps()
    assert taken(gaps, 7, 8, oldest=5) == [True, True]
    assert gaps.wanted(next(LATER)) == [(5, 6)]  # the drone still has them
    assert taken(gaps, 5, 6) == [True, True]
    assert taken(gaps, 12, 14) == [True, True]
    assert gaps.wanted(next(LATER)) == [(9, 11), (13, 13)]
    assert gaps.wanted(next(LATER), 1) == [(9, 11)]
    assert taken(gaps, 10, 10, 14, 3) == [True, False, False, False]
    assert gaps.wanted(next(LATER)) == [(9, 9), (11, 11), (13, 13)]
    assert gaps.repeated == 3
    assert taken(gaps, 15, oldest=11) == [True]
    assert gaps.wanted(next(LATER)) == [(11, 11), (13, 13)]
    assert gaps.lost == 1
    assert taken(gaps, 30, oldest=28) == [True]
    assert gaps.wanted(next(LATER)) == [(28, 29)]
    assert gaps.lost == 1 + 2 + 12


def test_a_restarted_drone_begins_anew_and_its_former_sightings_are_refused():
    gaps = Gaps()
    taken(gaps, 0, 5)
    assert gaps.take(sent(0, session=9))
    assert gaps.session == 9
    assert (gaps.wanted(next(LATER)), gaps.lost) == ([], 4)
    assert not gaps.take(sent(3, session=5))
    assert gaps.take(sent(1, session=9))


def test_no_number_makes_it_ask_for_more_than_a_drone_can_keep():
    gaps = Gaps()
    taken(gaps, 0, 2**62)
    assert gaps.wanted(next(LATER)) == [(2**62 - TUNING.most, 2**62 - 1)]


@given(st.lists(st.integers(0, 30), max_size=80))
def test_each_number_is_new_once_and_what_is_missing_is_the_rest(numbers):
    gaps = Gaps()
    new = [number for number in numbers if gaps.take(sent(number))]
    assert len(new) == len(set(new))
    assert set(new) == set(numbers)
    missing = {n for first, last in gaps.wanted(next(LATER), 99) for n in range(first, last + 1)}
    assert missing == set(range(max(numbers, default=0))) - set(numbers)


def test_what_has_been_asked_for_is_given_time_to_come():
    gaps = Gaps()
    taken(gaps, 0, 51)
    assert gaps.wanted(0) == [(1, 50)]
    assert gaps.wanted(2_900_000_000) == []  # 2 s, and 1 s for 50 at 100 a second
    taken(gaps, *range(1, 49), 53)
    assert gaps.wanted(2_900_000_000) == [(52, 52)]
    assert gaps.wanted(3_100_000_000) == [(49, 50)]


@pytest.mark.parametrize(
    ("delay_s", "again_s"), [(math.nan, 2.02), (-3.0, 2.02), (1.5, 5.02), (3600.0, 12.02)]
)
def test_what_is_on_its_way_over_a_slow_link_is_not_asked_for_again(delay_s, again_s):
    gaps = Gaps()
    assert taken(gaps, 0, 2) == [True, True]
    assert gaps.wanted(0, delay_s=delay_s) == [(1, 1)]
    assert gaps.wanted(round((again_s - 0.1) * 1e9), delay_s=delay_s) == []
    assert gaps.wanted(round((again_s + 0.1) * 1e9), delay_s=delay_s) == [(1, 1)]
