# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values between two samples, with numbers that anybody can check."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.core.telemetry.interpolation import (
    interpolate_fixes,
    interpolate_orientations,
    interpolate_scalars,
)
from aerial_gnss_ros.core.telemetry.jumps import fix_step
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar


def _fix(latitude_deg, longitude_deg, altitude=0.0, covariance=None, valid=True):
    place = math.radians(latitude_deg), math.radians(longitude_deg), altitude
    return Fix(0, *place, covariance, valid)


def test_a_scalar_is_where_it_is_on_the_line():
    found = interpolate_scalars(Scalar(0, 10.0), Scalar(8, 14.0), 0.25, 2)
    assert (found.stamp_ns, found.value) == (2, 11.0)


@pytest.mark.parametrize(
    ("before", "after", "longitude"),
    [(10.0, 14.0, 11.0), (179.0, -177.0, 180.0), (-179.0, 177.0, 180.0), (-170.0, 178.0, -173.0)],
)
def test_a_fix_goes_the_shorter_way_round(before, after, longitude):
    found = interpolate_fixes(_fix(-1.0, before, 5.0), _fix(3.0, after, 1.0), 0.25, 7)
    assert found.stamp_ns == 7
    assert math.degrees(found.latitude) == pytest.approx(0.0, abs=1e-12)
    assert found.altitude == pytest.approx(4.0)
    assert math.cos(found.longitude - math.radians(longitude)) == pytest.approx(1.0)
    assert abs(found.longitude) <= math.pi


@pytest.mark.parametrize(("first", "second"), [(True, False), (False, True), (False, False)])
def test_a_fix_is_valid_where_both_are(first, second):
    assert interpolate_fixes(_fix(0, 0), _fix(0, 0), 0.5, 0).valid
    assert not interpolate_fixes(_fix(0, 0, valid=first), _fix(0, 0, valid=second), 0.5, 0).valid


def test_a_covariance_is_mixed_or_that_of_the_one_that_has_it():
    one, other = np.diag([1.0, 2.0]), np.diag([5.0, 10.0])
    for before, after, expected in (
        (one, other, np.diag([2.0, 4.0])),
        (one, None, one),
        (None, other, other),
    ):
        found = interpolate_fixes(
            _fix(0, 0, covariance=before), _fix(0, 0, covariance=after), 0.25, 0
        )
        np.testing.assert_allclose(found.covariance, expected)
    assert interpolate_fixes(_fix(0, 0), _fix(0, 0), 0.25, 0).covariance is None


def test_an_orientation_goes_the_shortest_way():
    ends = [Orientation(0, Rotation.from_euler("z", deg, degrees=True).as_quat())
            for deg in (170.0, -150.0)]  # fmt: skip
    found = interpolate_orientations(*ends, 0.25, 3)
    assert found.stamp_ns == 3
    turned = Rotation.from_quat(found.quaternion).as_euler("zyx", degrees=True)[0]
    assert abs(turned) == pytest.approx(180.0)
    assert found.reference == ends[0].reference


def test_between_frames_there_is_no_orientation():
    ends = [Orientation(0, np.array([0.0, 0.0, 0.0, 1.0]), name) for name in ("earth", "body")]
    assert np.isnan(interpolate_orientations(*ends, 0.5, 0).quaternion).all()


def test_until_a_jump_is_over_values_are_what_they_were_without_it():
    """A receiver flies North by 10 m and jumps by 30 m East and 40 m South; a height by -5 m."""
    north, east = math.radians(10.0 / 110_600.0), math.radians(30.0 / 108_500.0)
    before = Fix(0, math.radians(13.0), math.radians(-59.0), 20.0)
    after = Fix(10, before.latitude - 3.0 * north, before.longitude + east, 20.0)
    jumped = replace(
        after, jumped=fix_step(before, replace(after, latitude=after.latitude - north))
    )
    found = interpolate_fixes(before, jumped, 0.5, 5)
    assert found.valid
    assert found.jumped == ()
    assert fix_step(before, found) == pytest.approx((0.0, 5.0), abs=0.01)
    back = interpolate_fixes(jumped, before, 0.5, 5)
    assert back.jumped == jumped.jumped
    assert fix_step(jumped, back) == pytest.approx((0.0, -5.0), abs=0.01)
    height = interpolate_scalars(Scalar(0, 20.0), Scalar(10, 16.0, (-5.0,)), 0.5, 5)
    assert height == Scalar(5, 20.5)
    assert interpolate_scalars(Scalar(0, 16.0, (-5.0,)), Scalar(10, 20.0), 0.5, 5).value == 15.5


def test_across_a_jump_there_is_no_orientation():
    one = Orientation(0, np.array([0.0, 0.0, 0.0, 1.0]))
    assert np.isnan(
        interpolate_orientations(one, replace(one, jumped=(0.3,)), 0.5, 0).quaternion
    ).all()
    kept = interpolate_orientations(*[replace(one, jumped=(0.3,))] * 2, 0.5, 0)
    assert kept.jumped == (0.3,)
