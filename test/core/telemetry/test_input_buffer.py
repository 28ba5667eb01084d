# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What samples of one input show of one another: repeated, wrong alone, displaced, uncertain."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.telemetry.input_buffer import (
    fix_buffer,
    orientation_buffer,
    scalar_buffer,
)
from aerial_gnss_ros.core.telemetry.series import Missing
from aerial_gnss_ros.core.telemetry.validity import unusable
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

SECOND = 10**9


def heights(values, every_s=0.1):
    """Return a buffer of heights, and what it says of each."""
    buffer = scalar_buffer(2.5, 60.0)
    told = [
        buffer.add(Scalar(round(k * every_s * SECOND), value), 0.0)
        for k, value in enumerate(values)
    ]
    return buffer, told


def test_one_sample_that_is_wrong_is_told_with_the_next_one_and_never_stored():
    buffer, told = heights([20.0] * 30 + [13.0] + [20.0] * 2)
    assert told == [""] * 31 + ["it lies 7 m off those before and after it, which agree", ""]
    assert len(buffer.series) == 32
    turned = orientation_buffer(2.5, 60.0)
    for k in range(32):
        half = math.radians(25.0) / 2 if k == 30 else 0.0
        quaternion = np.array([0.0, 0.0, math.sin(half), math.cos(half)])
        said = turned.add(Orientation(k * SECOND // 10, quaternion), 0.0)
    assert said == "it lies 25 deg off those before and after it, which agree"


def test_an_unusable_sample_ends_what_is_held_and_has_no_value_beside_it():
    buffer, _ = heights([20.0] * 30 + [13.0])
    assert buffer.series.last_stamp_ns == 29 * SECOND // 10
    buffer.add_unusable(unusable(Scalar(31 * SECOND // 10, 1.0)))
    assert [one.value for one in buffer.series.values[-2:]] == [
        13.0,
        pytest.approx(math.nan, nan_ok=True),
    ]
    sample, _ = buffer.at(round(3.05 * SECOND))
    assert math.isnan(sample.value.value)


def test_between_samples_a_value_is_uncertain_and_at_one_it_is_not():
    buffer, _ = heights([20.0] * 30, every_s=1.0)
    assert buffer.at(5 * SECOND)[1] is None
    sample, error = buffer.at(round(5.5 * SECOND))
    assert (sample.value.value, sample.gap_s) == (20.0, 1.0)
    assert error.variance[0] > 0.0
    assert buffer.at(99 * SECOND) is Missing.STALE
    buffer.clear()
    assert buffer.at(5 * SECOND) is Missing.NONE


def test_a_jump_makes_no_value_uncertain():
    values = [20.0] * 30 + [12.0] * 30
    jumped, _ = heights(values)
    steady, _ = heights([20.0] * 60)
    at_ns = round(4.05 * SECOND)
    assert jumped.at(at_ns)[0].value.jumped == pytest.approx((-8.0,))
    usual = steady.at(at_ns)[1].variance
    fresh, _ = heights([20.0, 20.0])
    assert usual[0] < 0.5 * fresh.at(round(0.05 * SECOND))[1].variance[0]  # it has learnt
    assert jumped.at(at_ns)[1].variance == pytest.approx(usual, rel=0.3)  # 8 m: a million times


def test_values_that_were_sent_again_had_not_jumped():
    """A receiver at 1 Hz that is sent at 10 Hz stands, and jumps by 5 m each second."""
    buffer = fix_buffer(2.5, 60.0)
    for k in range(100):
        buffer.add(Fix(k * SECOND // 10, 0.2 + 8e-7 * (k // 10), 0.1, 0.0), 0.0)
    assert any(one.jumped for one in buffer.series.values)
    buffer.discard_repeated(1.5, lambda _fix: True)
    assert [one.stamp_ns // SECOND for one in buffer.series.values] == list(range(10))
    assert not any(one.jumped for one in buffer.series.values)
    buffer.add_unusable(unusable(Fix(10 * SECOND, 0.2, 0.1, 0.0)))
    buffer.discard_repeated(1.5, lambda fix: fix.valid)
    assert [one.valid for one in buffer.series.values] == [True] * 10 + [False]
