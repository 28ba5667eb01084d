# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flags and fields of px4_msgs that come and go between releases."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.adapters import px4
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.validity import validate

FIX = estimator_config(
    {"fix.type": "px4_global_position", "fix.stamp": "px4_us", "fix.altitude_datum": "ellipsoid"}
).fix
POSITION = {"lat": 45.0, "lon": -90.0, "alt": 10.0, "alt_ellipsoid": -30.0, "eph": 2.0, "epv": 3.0}
LOCAL = {"z": -12.0, "z_valid": True, "dist_bottom": 11.5, "dist_bottom_valid": True}


def position(**changed):
    return px4.global_position(SimpleNamespace(**POSITION | changed), 5, FIX)


def test_a_position_of_v1_14_has_no_flags_and_counts():
    fix = position()
    assert (fix.stamp_ns, fix.valid, fix.altitude) == (5, True, -30.0)
    assert fix.latitude == pytest.approx(math.pi / 4)
    np.testing.assert_array_equal(np.diagonal(fix.covariance), [4.0, 4.0, 9.0])


def test_flags_of_later_releases_are_heeded():
    assert not position(lat_lon_valid=False, alt_valid=True).valid
    assert math.isnan(position(lat_lon_valid=True, alt_valid=False).altitude)


def test_no_accuracy_is_no_covariance():
    assert position(eph=0.0).covariance is None


@pytest.mark.parametrize("eph", [math.nan, math.inf, -math.inf, -2.0])
def test_an_accuracy_that_is_no_number_makes_no_fix(eph):
    assert "covariance" in validate(position(eph=eph))[0]


def test_raw_gnss_without_a_fix_is_none():
    fields = {"latitude_deg": 1.0, "longitude_deg": 2.0, "altitude_msl_m": 3.0, "epv": 1.0}
    fields |= {"altitude_ellipsoid_m": 4.0, "eph": 1.0}
    for kind, valid in ((0, False), (1, False), (2, True), (3, True), (6, True)):
        assert px4.sensor_gps(SimpleNamespace(**fields, fix_type=kind), 5, FIX).valid == valid


@pytest.mark.parametrize(
    ("changed", "origin", "bottom"),
    [
        ({}, 12.0, 11.5),
        ({"z_valid": False}, math.nan, 11.5),
        ({"dist_bottom_valid": False}, 12.0, math.nan),
    ],
)
def test_heights_that_are_not_valid_are_nan(changed, origin, bottom):
    msg = SimpleNamespace(**LOCAL | changed)
    assert px4.height_above_origin(msg, 5, None).value == pytest.approx(origin, nan_ok=True)
    assert px4.height_above_bottom(msg, 5, None).value == pytest.approx(bottom, nan_ok=True)


def test_stamps_are_microseconds():
    stamp_us = 1_700_000_000_123_456
    assert px4.nanoseconds(SimpleNamespace(timestamp=np.uint64(stamp_us))) == stamp_us * 1000
