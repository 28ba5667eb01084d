# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What no platform flies is a sample that is wrong alone, or a jump, which all later ones show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from pyproj import Geod

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.telemetry.jumps import (
    TUNING,
    fix_jumps,
    fix_step,
    orientation_jumps,
    scalar_jumps,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

WGS84 = Geod(ellps="WGS84")


def fixes(norths, hz=5.0, noise_m=0.02, speed_mps=4.0):
    """Return fixes of a drone that flies East at 13° North, displaced to the North by metres."""
    rng = np.random.default_rng(1)
    found = []
    for k, north in enumerate(norths):
        east_m, north_m = noise_m * rng.standard_normal(2) + (speed_mps * k / hz, north)
        lon, lat, _ = WGS84.fwd(-59.0, 13.0, 90.0, east_m)
        lon, lat, _ = WGS84.fwd(lon, lat, 0.0, north_m)
        found.append(Fix(round(k / hz * 1e9), math.radians(lat), math.radians(lon), 20.0))
    return found


def taken(samples, filter_):
    """Return the stamps and jumps of what can be used after each sample, and what was left out."""
    return [
        ([(round(one.stamp_ns * 1e-9, 3), one.jumped) for one in filter_.update(value)],
         filter_.left_out)
        for value in samples
    ]  # fmt: skip


@pytest.mark.parametrize("north", [2.0, 5.0, -40.0])
def test_one_position_that_is_off_is_left_out_when_the_next_one_comes(north):
    found = taken(fixes([0.0] * 30 + [north] + [0.0] * 5), fix_jumps())
    assert [[stamp for stamp, _ in used] for used, _ in found[29:33]] == [[5.8], [], [6.2], [6.4]]
    assert [off for _, off in found[:31]] == [0.0] * 31
    assert found[31][1] == pytest.approx(abs(north), abs=0.1)
    assert not any(jumped for used, _ in found for _, jumped in used)


def test_after_a_jump_nothing_is_extrapolated_from_before_it():
    """The drone is turned away by a jump of its own: a simulator's that begins elsewhere."""
    there = fixes([0.0] * 30)
    back = [
        replace(one, stamp_ns=one.stamp_ns + 6_000_000_000)
        for one in fixes([50.0] * 12, speed_mps=-4.0)
    ]
    del back[3:5]  # so that the next one is farther ahead than those held reach back
    found = taken(there + back, fix_jumps())
    assert [len(used) for used, _ in found[30:]] == [0, 0, 3, *[1] * 7]
    assert not any(off for _, off in found)


def test_positions_that_stay_away_have_jumped_and_may_come_back():
    found = taken(fixes([0.0] * 30 + [2.0] * 10 + [0.0] * 10), fix_jumps())
    jumps = [jumped for used, _ in found for _, jumped in used]
    assert jumps[:30] == [()] * 30
    assert len(set(jumps[30:40])) == 1
    assert jumps[30] == pytest.approx((0.0, 2.0), abs=0.15)
    assert jumps[40:] == [()] * 10  # the very place, not one that differs by noise
    # held until it is certain, and no longer
    assert [len(used) for used, _ in found[29:34]] == [1, 0, 0, 3, 1]
    assert not any(off for _, off in found)


@pytest.mark.parametrize(("hz", "count"), [(400.0, 121), (30.0, 10), (10.0, 4), (1.0, 2)])
def test_samples_are_held_for_a_moment_only(hz, count):
    found = taken(fixes([0.0] * 300 + [60.0] * 130, hz=hz), fix_jumps())
    sizes = [len(used) for used, _ in found[300:]]
    assert sizes.index(max(sizes)) == count - 1
    assert max(sizes) == count
    assert (count - 1) / hz >= TUNING.held_s


@pytest.mark.parametrize(
    "norths",
    [
        [0.1 * k * k / 2 for k in range(40)],  # speeds up by 2.5 m/s²
        [5.0 * math.sin(k / 3.0) for k in range(80)],  # flies bends of 14 m/s²
        list(2.0 * np.random.default_rng(2).standard_normal(60)),  # a poor receiver
    ],
    ids=["speeds up", "bends", "noise"],
)
def test_what_a_drone_flies_or_a_receiver_usually_does_is_no_jump(norths):
    samples = fixes(norths)
    found = taken(samples, fix_jumps())
    assert [used for used, _ in found] == [[(round(s.stamp_ns * 1e-9, 3), ())] for s in samples]


def test_after_a_gap_nothing_is_extrapolated():
    samples = fixes([0.0] * 30 + [30.0] * 3)
    later = [replace(one, stamp_ns=one.stamp_ns + 5_000_000_000) for one in samples[30:]]
    assert all(len(used) == 1 for used, _ in taken(samples[:30] + later, fix_jumps()))


def test_a_gap_tells_nothing_of_what_is_held():
    filter_ = fix_jumps()
    samples = fixes([0.0] * 30 + [9.0])
    taken(samples, filter_)
    later = replace(samples[-1], stamp_ns=samples[-1].stamp_ns + 20_000_000_000)
    used = filter_.update(later)
    assert [(one.stamp_ns, one.jumped) for one in used] == [
        (samples[-1].stamp_ns, ()),
        (later.stamp_ns, ()),
    ]
    assert not filter_.left_out


def test_a_late_sample_is_used_as_it_is():
    filter_ = fix_jumps()
    samples = fixes([0.0] * 30 + [3.0] * 3)
    taken(samples, filter_)
    late = replace(samples[20], stamp_ns=samples[20].stamp_ns + 1)
    (used,) = filter_.update(late)
    assert used.stamp_ns == late.stamp_ns
    again = replace(samples[32], altitude=21.0)  # another value with the last stamp
    (newest,) = filter_.update(again)
    assert newest == replace(again, jumped=used.jumped)
    assert used.jumped != ()
    assert filter_.update(fixes([0.0] * 33 + [3.0])[-1])[0].jumped == used.jumped


def test_what_is_held_is_given_back_when_a_message_is_of_no_use():
    filter_ = fix_jumps()
    samples = fixes([0.0] * 30 + [9.0])
    taken(samples, filter_)
    assert [one.stamp_ns for one in filter_.interrupt()] == [samples[-1].stamp_ns]
    assert filter_.interrupt() == []
    taken(samples, filter_)
    assert [one.stamp_ns for one in filter_.clear()] == [samples[-1].stamp_ns]


def test_an_orientation_and_a_height_that_are_off_once_are_left_out():
    yaws = [0.5 * k for k in range(20)] + [25.0] + [0.5 * k for k in range(21, 24)]
    turned = [
        Orientation(k * 10**8, quaternion_from_matrix(matrix_from_rpy(0.0, 0.9, math.radians(yaw))))
        for k, yaw in enumerate(yaws)
    ]
    turned[22] = replace(turned[22], quaternion=-turned[22].quaternion)  # the same rotation
    found = taken(turned, orientation_jumps())
    assert [len(used) for used, _ in found[19:]] == [1, 0, 1, 1, 1]
    assert found[21][1] == pytest.approx(math.radians(15.0), rel=0.01)
    heights = [Scalar(k * 10**8, 20.0 - 6.0 * (k == 20)) for k in range(23)]
    found = taken(heights, scalar_jumps())
    assert [len(used) for used, _ in found[19:]] == [1, 0, 1, 1]
    assert found[21][1] == pytest.approx(6.0)


def test_steps_are_metres_on_the_ellipsoid():
    here = Fix(0, math.radians(54.0), math.radians(179.9999), 0.0)
    for azimuth in (0.0, 70.0, 200.0):
        lon, lat, _ = WGS84.fwd(179.9999, 54.0, azimuth, 20.0)
        step = fix_step(here, Fix(0, math.radians(lat), math.radians(lon), 0.0))
        turn = math.radians(azimuth)
        assert step == pytest.approx((20.0 * math.sin(turn), 20.0 * math.cos(turn)), abs=1e-3)
