# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Core telemetry values as nested dicts in ROS field names: the reverse of `canonical`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

FIX_TYPE = "sensor_msgs/msg/NavSatFix"
IMU_TYPE = "sensor_msgs/msg/Imu"
QUATERNION_TYPE = "geometry_msgs/msg/QuaternionStamped"
FLOAT_TYPE = "std_msgs/msg/Float64"
CAMERA_INFO_TYPE = "sensor_msgs/msg/CameraInfo"

_STATUS_FIX, _STATUS_NO_FIX, _SERVICE_GPS = 0, -1, 1
_COVARIANCE_UNKNOWN, _COVARIANCE_KNOWN = 0, 3


def fix_fields(fix: Fix, frame_id: str = "gnss") -> dict[str, Any]:
    """Return a sensor_msgs/NavSatFix; radians become degrees here."""
    known = fix.covariance is not None
    covariance = np.zeros(9) if fix.covariance is None else fix.covariance.ravel()
    return {
        "header": header_fields(fix.stamp_ns, frame_id),
        "status": {
            "status": _STATUS_FIX if fix.valid else _STATUS_NO_FIX,
            "service": _SERVICE_GPS,
        },
        "latitude": math.degrees(fix.latitude),
        "longitude": math.degrees(fix.longitude),
        "altitude": fix.altitude,
        "position_covariance": [float(value) for value in covariance],
        "position_covariance_type": _COVARIANCE_KNOWN if known else _COVARIANCE_UNKNOWN,
    }


def imu_fields(attitude: Orientation, frame_id: str = "body") -> dict[str, Any]:
    """Return a sensor_msgs/Imu with only an orientation (-1 marks the rest as absent)."""
    absent = [-1.0] + [0.0] * 8
    return {
        "header": header_fields(attitude.stamp_ns, frame_id),
        "orientation": _quaternion(attitude),
        "angular_velocity_covariance": absent,
        "linear_acceleration_covariance": absent,
    }


def quaternion_fields(orientation: Orientation, frame_id: str) -> dict[str, Any]:
    """Return a geometry_msgs/QuaternionStamped.

    Args:
        orientation: the body or the camera.
        frame_id: its reference frame, such as `enu`.
    """
    return {
        "header": header_fields(orientation.stamp_ns, frame_id),
        "quaternion": _quaternion(orientation),
    }


def float_fields(scalar: Scalar) -> dict[str, Any]:
    """Return a std_msgs/Float64; it carries no stamp."""
    return {"data": scalar.value}


def camera_info_fields(camera: CameraModel, stamp_ns: int, frame_id: str) -> dict[str, Any]:
    """Return a sensor_msgs/CameraInfo of images that are not rectified."""
    projection = np.zeros((3, 4))
    projection[:, :3] = camera.K
    return {
        "header": header_fields(stamp_ns, frame_id),
        "width": camera.width,
        "height": camera.height,
        "distortion_model": camera.model,
        "d": [float(value) for value in camera.D],
        "k": [float(value) for value in camera.K.ravel()],
        "r": [float(value) for value in np.eye(3).ravel()],
        "p": [float(value) for value in projection.ravel()],
    }


def _quaternion(orientation: Orientation) -> dict[str, float]:
    return dict(zip("xyzw", map(float, orientation.quaternion), strict=True))
