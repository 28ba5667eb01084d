# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values written as messages and read again are the same."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters import telemetry_fields as fields
from aerial_gnss_ros.bags.typestore import serialize, typestore
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

STAMP = 1_700_000_000_123_456_789


def through_cdr(msgtype, values):
    return typestore().deserialize_cdr(serialize(msgtype, values), msgtype)


@pytest.mark.parametrize("covariance", [None, np.diag([1.0, 2.0, 3.0])])
@pytest.mark.parametrize("valid", [True, False])
def test_fix(covariance, valid):
    given = Fix(STAMP, math.radians(13.19), math.radians(-59.64), math.nan, covariance, valid)
    message = through_cdr(fields.FIX_TYPE, fields.fix_fields(given))
    got = canonical.fix(message, STAMP)
    assert got.latitude == pytest.approx(given.latitude, abs=1e-15)
    assert message.longitude == pytest.approx(-59.64)
    assert math.isnan(got.altitude)
    assert got.valid is valid
    np.testing.assert_equal(got.covariance, covariance)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == divmod(STAMP, 10**9)


def test_orientations_and_height():
    given = Orientation(STAMP, np.array([0.5, -0.5, 0.5, 0.5]))
    imu = through_cdr(fields.IMU_TYPE, fields.imu_fields(given))
    np.testing.assert_equal(canonical.orientation(imu, STAMP, "imu").quaternion, given.quaternion)
    assert imu.angular_velocity_covariance[0] == -1.0
    turned = through_cdr(fields.QUATERNION_TYPE, fields.quaternion_fields(given, "enu"))
    got = canonical.orientation(turned, STAMP, "quaternion")
    np.testing.assert_equal(got.quaternion, given.quaternion)
    height = through_cdr(fields.FLOAT_TYPE, fields.float_fields(Scalar(STAMP, 12.5)))
    assert canonical.scalar(height, STAMP) == Scalar(STAMP, 12.5)


def test_camera_info():
    K = np.array([[800.0, 0, 640], [0, 810, 360], [0, 0, 1]])
    given = CameraModel(1280, 720, "plumb_bob", K, np.array([-0.1, 0.02, 1e-3, -1e-3, 0.0]))
    message = through_cdr(
        fields.CAMERA_INFO_TYPE, fields.camera_info_fields(given, STAMP, "camera")
    )
    got = canonical.camera(message, rectified=False)
    np.testing.assert_equal(got.K, given.K)
    np.testing.assert_equal(got.D, given.D)
    assert (got.width, got.height, got.model) == (1280, 720, "plumb_bob")
    np.testing.assert_equal(canonical.camera(message, rectified=True).K, given.K)
