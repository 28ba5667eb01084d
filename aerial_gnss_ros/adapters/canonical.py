# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Converts messages on the canonical topics to core values, by attribute only.

The same functions serve rclpy messages and those that rosbags reads from a bag. They only convert;
the core judges whether a value is usable (not a zero quaternion, not NaN), and counts refusals.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import axes
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar
from aerial_gnss_ros.text.plain_text import printable

NO_FIX = -1  # sensor_msgs/NavSatStatus.STATUS_NO_FIX
NO_ORIENTATION = -1.0  # first element of sensor_msgs/Imu.orientation_covariance (REP 145)
COVARIANCE_UNKNOWN = 0  # sensor_msgs/NavSatFix.COVARIANCE_TYPE_UNKNOWN


def fix(msg: Any, stamp_ns: int) -> Fix:
    """Return a sensor_msgs/NavSatFix as a value; degrees become radians here."""
    return Fix(
        stamp_ns=stamp_ns,
        latitude=math.radians(msg.latitude),
        longitude=math.radians(msg.longitude),
        altitude=float(msg.altitude),
        covariance=_fix_covariance(msg),
        valid=int(msg.status.status) != NO_FIX,  # -2 means unknown: from drivers that set no status
    )


def _fix_covariance(msg: Any) -> Array | None:
    """Return the covariance (3, 3) East, North, Up, or None if the message has none.

    Simulators and some drivers set a type but leave the variances at zero, which also counts as
    none: no GNSS is perfect.
    """
    if int(msg.position_covariance_type) == COVARIANCE_UNKNOWN:
        return None
    covariance = np.asarray(msg.position_covariance, dtype=np.float64).reshape(3, 3)
    return covariance if covariance[:2, :2].any() else None


def orientation(msg: Any, stamp_ns: int, kind: str, unit: str = "rad") -> Orientation:
    """Return an orientation in the message's own axes.

    Args:
        msg: sensor_msgs/Imu, geometry_msgs/QuaternionStamped or Vector3Stamped.
        stamp_ns: time of validity, ns.
        kind: `imu`, `quaternion`, or `vector3`: roll, pitch, yaw, as R = Rz Ry Rx.
        unit: of a vector's angles, `rad` or `deg`.

    Returns:
        The orientation; NaN, so that the core refuses it, if angles are not finite or an Imu states
        that it measures none: such messages often contain the identity, level and facing east.
    """
    if kind == "vector3":
        angles = np.array([msg.vector.x, msg.vector.y, msg.vector.z], dtype=np.float64)
        rpy = np.radians(angles) if unit == "deg" else angles
        return Orientation(stamp_ns, axes.from_angles(*rpy.tolist()))
    if kind == "imu" and float(msg.orientation_covariance[0]) == NO_ORIENTATION:
        return Orientation(stamp_ns, np.full(4, np.nan))
    q = msg.orientation if kind == "imu" else msg.quaternion
    return Orientation(stamp_ns, np.array([q.x, q.y, q.z, q.w], dtype=np.float64))


def scalar(msg: Any, stamp_ns: int) -> Scalar:
    """Return a std_msgs/Float64 or Float32, or the range of a sensor_msgs/Range.

    A range outside the sensor's own limits is no measurement (REP 117), and many sensors send
    exactly the least or the greatest instead: both become NaN. Limits of 0, 0 mean unknown.
    """
    if not hasattr(msg, "range"):
        return Scalar(stamp_ns, float(msg.data))
    near, far, value = float(msg.min_range), float(msg.max_range), float(msg.range)
    outside = far > near and not near < value < far
    return Scalar(stamp_ns, math.nan if outside else value)


def camera(msg: Any, rectified: bool) -> CameraModel:
    """Return the camera that a sensor_msgs/CameraInfo describes.

    Args:
        msg: of ROS 2 (`d`, `k`, `r`, `p`) or of ROS 1 (`D`, `K`, `R`, `P`).
        rectified: True when the images are rectified.

    Raises:
        CameraError: zeros, an unknown distortion model, binning or a region of interest.
    """
    width, height, model, d, k, r, p, binning, roi = _camera_fields(msg)
    return CameraModel.from_camera_info(
        width, height, model, d, k, r, p, rectified, binning=binning, roi=roi
    )


def camera_key(msg: Any) -> tuple[Any, ...]:
    """Return a key that is equal for messages that describe the same camera."""
    return tuple(
        field.tobytes() if isinstance(field, np.ndarray) else field for field in _camera_fields(msg)
    )


def _camera_fields(msg: Any) -> tuple[Any, ...]:
    d, k, r, p = (
        np.asarray(
            getattr(msg, name) if hasattr(msg, name) else getattr(msg, name.upper()),
            dtype=np.float64,
        )
        for name in "dkrp"
    )
    roi = msg.roi
    return (
        int(msg.width),
        int(msg.height),
        str(msg.distortion_model),
        d,
        k,
        r,
        p,
        (int(msg.binning_x), int(msg.binning_y)),
        (int(roi.x_offset), int(roi.y_offset), int(roi.width), int(roi.height)),
    )


def detection_frame(msg: Any) -> DetectionFrame:
    """Return a vision_msgs/Detection2DArray.

    The best hypothesis of each box is used. A box without one gets score 0 and no class, so that it
    is counted as refused.
    """
    boxes = [detection.bbox for detection in msg.detections]
    best = [_best(detection.results) for detection in msg.detections]
    centers = [(box.center.position.x, box.center.position.y) for box in boxes]
    sizes = [(box.size_x, box.size_y) for box in boxes]
    return DetectionFrame(
        stamp_ns=nanoseconds(msg.header.stamp),
        frame_id=str(msg.header.frame_id),
        centers=np.array(centers, dtype=np.float64).reshape(-1, 2),
        sizes=np.array(sizes, dtype=np.float64).reshape(-1, 2),
        scores=np.array([score for _, score in best], dtype=np.float64),
        class_ids=tuple(name for name, _ in best),
    )


def _best(results: Any) -> tuple[str, float]:
    hypotheses = [
        (printable(str(r.hypothesis.class_id)), float(r.hypothesis.score)) for r in results
    ]
    return max(hypotheses, key=lambda h: h[1]) if hypotheses else ("", 0.0)
