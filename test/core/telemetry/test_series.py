# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Telemetry at a scene's time: interpolated between neighbours, or missing by type."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.telemetry.series import (
    Missing,
    Sample,
    fix_series,
    held_series,
    orientation_series,
    scalar_series,
)
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

SECOND = 10**9


def _heights(*pairs, max_gap=1.5, **options):
    series = scalar_series(max_gap, **options)
    for seconds, value in pairs:
        series.add(Scalar(round(seconds * SECOND), value))
    return series


def test_values_between_neighbours_are_linear_and_tell_the_age_of_the_farther_one():
    got = _heights((10, 5.0), (11, 7.0)).at(round(10.25 * SECOND))
    assert isinstance(got, Sample)
    assert got.value == Scalar(round(10.25 * SECOND), 5.5)
    assert got.age_s == pytest.approx(0.75)
    assert got.gap_s == pytest.approx(1.0)


def test_an_exact_hit_needs_no_neighbour():
    got = _heights((10, 5.0)).at(10 * SECOND)
    assert got == Sample(Scalar(10 * SECOND, 5.0), 0.0)


@pytest.mark.parametrize(
    ("seconds", "missing", "reason"),
    [
        (9.0, Missing.BEFORE, Reason.NO_HEIGHT),
        (12.0, Missing.GAP, Reason.GAP_HEIGHT),
        (14.5, Missing.WAIT, Reason.STALE_HEIGHT),
        (15.501, Missing.STALE, Reason.STALE_HEIGHT),
    ],
)
def test_nothing_is_extrapolated_and_the_reason_has_a_type(seconds, missing, reason):
    series = _heights((10, 5.0), (11, 7.0), (14, 9.0))
    got = series.at(round(seconds * SECOND))
    assert got is missing
    assert got.reason(Input.HEIGHT) is reason
    assert got.can_arrive == (missing in (Missing.WAIT, Missing.STALE))


def test_stamps_between_two_times_include_both():
    series = _heights((10, 5.0), (11, 7.0), (12, 9.0), (13, 9.0))
    stamps = series.stamps(11 * SECOND, 12 * SECOND)
    assert stamps == [11 * SECOND, 12 * SECOND]
    assert series.stamps(14 * SECOND, 15 * SECOND) == []


def test_neighbours_exactly_max_gap_apart_are_used():
    assert isinstance(_heights((10, 5.0), (11.5, 7.0)).at(11 * SECOND), Sample)
    assert _heights((10, 5.0), (11.500000001, 7.0)).at(11 * SECOND) is Missing.GAP


def test_an_empty_series_has_none():
    series = _heights()
    assert series.at(5) is Missing.NONE
    assert Missing.NONE.reason(Input.FIX) is Reason.NO_FIX
    assert (series.first_stamp_ns, series.last_stamp_ns, series.last) == (None, None, None)
    assert series.latest(5) is None


@given(st.permutations(range(12)))
def test_the_order_of_arrival_does_not_matter(order):
    series = _heights(*[(i, float(i * i)) for i in order])
    assert len(series) == 12
    assert (series.first_stamp_ns, series.last_stamp_ns) == (0, 11 * SECOND)
    for i in range(11):
        got = series.at(i * SECOND + SECOND // 2)
        assert got.value.value == pytest.approx((i * i + (i + 1) ** 2) / 2.0)


def test_a_second_sample_with_the_same_stamp_replaces_the_first():
    series = _heights((10, 5.0), (11, 7.0), (10, 6.0), (11, 8.0))
    assert len(series) == 2
    assert series.at(round(10.5 * SECOND)).value.value == pytest.approx(7.0)


def test_old_samples_are_forgotten_and_never_come_back():
    series = scalar_series(1.5, keep_s=10.0)
    for i in range(10_000):
        series.add(Scalar(i * SECOND // 10, float(i)))
    assert len(series) <= 102
    assert len(series._stamps) < 3000
    newest = series.last_stamp_ns
    assert series.at(newest - 5 * SECOND).value.value == pytest.approx(9949.0)
    assert series.at(newest - 20 * SECOND) is Missing.BEFORE
    series.add(Scalar(0, 1.0))  # far too late
    assert series.at(newest - 5 * SECOND).value.value == pytest.approx(9949.0)


def test_length_is_bounded():
    series = _heights(max_gap=1.5, keep_s=1e6)
    series._max_length = 100
    for i in range(5000):
        series.add(Scalar(i, 0.0))
    assert len(series) == 100


def test_clear_forgets_everything():
    series = _heights((10, 5.0), (11, 7.0))
    series.clear()
    assert len(series) == 0
    series.add(Scalar(1, 3.0))  # an earlier clock
    assert series.at(1).value.value == 3.0


def test_held_values_are_the_newest_not_later():
    series = held_series()
    for seconds in (10, 20):
        series.add(Scalar(seconds * SECOND, float(seconds)))
    assert series.latest(9 * SECOND) is None
    assert series.latest(10 * SECOND).value == 10.0
    assert series.latest(19 * SECOND).value == 10.0
    assert series.latest(500 * SECOND).value == 20.0
    series.add(Scalar(900 * SECOND, 1.0))
    assert (
        series.latest(899 * SECOND).value == 20.0
    )  # older than kept, and still the one that holds


def _fix(seconds, lon_deg, lat_deg=13.0, alt=5.0, covariance=None, valid=True):
    return Fix(
        round(seconds * SECOND),
        math.radians(lat_deg),
        math.radians(lon_deg),
        alt,
        covariance,
        valid,
    )


def _fix_between(first, second, fraction=0.25):
    series = fix_series(2.5)
    series.add(first)
    series.add(second)
    return series.at(first.stamp_ns + round(fraction * (second.stamp_ns - first.stamp_ns))).value


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_flight_across_the_antimeridian_stays_there(sign):
    got = _fix_between(_fix(0, sign * 179.9999), _fix(1, -sign * 179.9997))
    assert abs(math.degrees(got.longitude)) == pytest.approx(180.0)
    beyond = _fix_between(_fix(0, sign * 179.9999), _fix(1, -sign * 179.9997), 0.75)
    assert math.degrees(beyond.longitude) == pytest.approx(-sign * 179.9998)


def test_a_fix_keeps_what_its_neighbours_have():
    eye = np.eye(3)
    got = _fix_between(_fix(0, 10, 13.0, 4.0, eye), _fix(1, 10.0004, 13.0004, 8.0, 5.0 * eye))
    assert math.degrees(got.latitude) == pytest.approx(13.0001)
    assert math.degrees(got.longitude) == pytest.approx(10.0001)
    assert got.altitude == pytest.approx(5.0)
    assert got.covariance == pytest.approx(2.0 * eye)
    assert got.valid
    assert not _fix_between(_fix(0, 10, valid=False), _fix(1, 10)).valid
    assert math.isnan(_fix_between(_fix(0, 10, alt=math.nan), _fix(1, 10)).altitude)
    assert _fix_between(_fix(0, 10), _fix(1, 10, covariance=eye)).covariance is eye


def test_orientations_turn_the_short_way_whatever_the_quaternions_sign():
    series = orientation_series(0.5)
    half = math.radians(20.0) / 2
    series.add(Orientation(0, np.array([0.0, 0.0, 0.0, 1.0])))
    series.add(Orientation(SECOND // 5, -np.array([0.0, 0.0, math.sin(half), math.cos(half)])))
    got = series.at(SECOND // 10).value.quaternion
    assert got == pytest.approx([0.0, 0.0, math.sin(half / 2), math.cos(half / 2)])


def test_nothing_lies_between_orientations_relative_to_different_frames():
    series = orientation_series(1.0)
    same = np.array([0.0, 0.0, 0.0, 1.0])
    for stamp, reference in ((0, "earth"), (10, "heading"), (20, "heading")):
        series.add(Orientation(stamp, same, reference))
    assert np.isnan(series.at(5).value.quaternion).all()
    assert series.at(15).value.reference == "heading"
