# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How far off interpolated values are is learnt from the samples, and is as large as stated."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.telemetry.interpolation_error import (
    TUNING,
    fix_error,
    orientation_error,
    scalar_error,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

SECOND, METRE = 10**9, 1.0 / 6_378_137.0


def orientation(t, yaw=0.0, pitch=0.0):
    matrix = matrix_from_rpy(0.0, pitch, yaw)
    return Orientation(round(t * SECOND), quaternion_from_matrix(matrix))


@pytest.mark.parametrize("since", [0.1, 0.5, 0.7])
def test_the_error_is_as_large_as_stated(since):
    """A random walk of the rate, sampled once a second, against the line between its samples."""
    rng = np.random.default_rng(3)
    step, count, density = 0.02, 100_000, 0.3
    rate = np.cumsum(rng.normal(0.0, math.sqrt(density * step), count))
    value = np.cumsum(rate) * step
    whole = round(1.0 / step)
    place = np.arange(0, count - whole, whole) + round(since / step)
    ends = value[place - round(since / step)], value[place - round(since / step) + whole]
    off = value[place] - ((1.0 - since) * ends[0] + since * ends[1])
    error = scalar_error()
    stated = []
    for number, one in enumerate(value[::whole].tolist()):
        error.add(Scalar(number * SECOND, one))
        if number > 1:
            stated.append(error.at(round((number - 1 + since) * SECOND), since, 1.0).variance[0])
    assert np.mean(stated[100:]) == pytest.approx(np.mean(np.square(off)), rel=0.15)


def test_before_any_sample_the_expected_motion_counts_and_grows_with_the_cube_of_the_gap():
    error = fix_error()
    middle = error.at(0, 0.5, 1.0)
    assert middle.variance == (pytest.approx(TUNING.moved / 48.0),)
    assert middle.gap_s == 1.0
    assert error.at(0, 1.0, 2.0).variance[0] == pytest.approx(8.0 * middle.variance[0])
    assert error.at(0, 1.0, 1.0).variance == (0.0,)


def test_a_turn_makes_headings_uncertain_and_not_tilts():
    calm, turning = orientation_error(), orientation_error()
    for t in range(30):
        calm.add(orientation(t))
        turning.add(orientation(t, yaw=0.3 * math.sin(t)))
    still, turned = (one.at(40 * SECOND, 0.5, 1.0).variance for one in (calm, turning))
    assert turned[0] == pytest.approx(still[0])
    assert turned[1] > 30.0 * still[1]


def test_a_turn_within_a_long_gap_counts_at_once_and_only_there():
    error = orientation_error()
    for t in np.arange(0.0, 60.0, 0.1):
        error.add(orientation(t))
    before = error.at(59 * SECOND, 1.0, 2.0).variance
    error.add(orientation(62.0, pitch=0.5))
    inside = error.at(61 * SECOND, 1.0, 2.0).variance
    assert math.sqrt(before[0]) < 0.01
    assert math.sqrt(inside[0]) > 0.04
    assert error.at(61 * SECOND, 0.05, 0.1).variance[0] < 1e-3 * inside[0]  # short gaps know better


def test_northings_and_eastings_are_metres():
    error = fix_error()
    for t in range(200):
        wave = math.cos(math.pi * t)  # 1 m to either side, in turn
        east = wave * METRE / math.cos(0.5)
        error.add(Fix(t * SECOND, 0.5 + wave * METRE, 3.14159265 + east, 0.0))
    # each sample is 2 m in both off its neighbours: 6 · 4 m²/s³
    assert error.at(0, 0.1, 0.2).variance[0] == pytest.approx(24.0 * 0.1**4 / 0.6, rel=0.1)


def test_what_is_no_value_or_too_far_away_tells_nothing():
    error = orientation_error()
    nothing = error.at(0, 0.5, 1.0)
    for t in (0.0, 1.0, 2.0, 30.0):
        error.add(
            orientation(t) if t == 0.0 else Orientation(round(t * SECOND), np.full(4, np.nan))
        )
    for t in (60.0, 70.0, 90.0):
        error.add(orientation(t, yaw=t))
    assert error.at(0, 0.5, 1.0) == nothing
    error.add(orientation(91.0))
    error.clear()
    assert error.at(0, 0.5, 1.0) == nothing


def test_a_jump_of_the_sensor_is_no_motion():
    def learnt(jump):
        error = fix_error()
        for k in range(40):
            if jump and k == 20:
                error.interrupt()
            error.add(Fix(k * 10**9, 0.2 + (1e-6 if k >= 20 else 0.0), 0.0, 0.0))
        return error.at(39_500_000_000, 0.5, 1.0).variance[0]

    assert learnt(jump=False) > 3.0 * learnt(jump=True)
