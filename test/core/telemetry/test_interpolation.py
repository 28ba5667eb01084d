# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values between two samples, with numbers that anybody can check."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.core.telemetry.interpolation import (
    interpolate_fixes,
    interpolate_orientations,
    interpolate_scalars,
)
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
