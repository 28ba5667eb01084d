# SPDX-License-Identifier: Apache-2.0
"""A DJI flight record as a bag on the canonical topics."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.dji_log import DjiLog
from aerial_gnss_ros.adapters.telemetry_fields import (
    CAMERA_INFO_TYPE,
    FIX_TYPE,
    FLOAT_TYPE,
    IMU_TYPE,
    QUATERNION_TYPE,
    camera_info_fields,
    fix_fields,
    float_fields,
    imu_fields,
    quaternion_fields,
)
from aerial_gnss_ros.bags.writer import SENSOR, BagWriter
from aerial_gnss_ros.core.camera import CameraModel

START_NS = 1_735_689_600_000_000_000
"""The log's first row, where the user names no time: the log tells no date. 2025-01-01, 0 h UTC."""

Message = tuple[int, str, str, dict[str, Any]]


def write_dji_bag(
    log: DjiLog,
    path: Path,
    *,
    camera: CameraModel | None = None,
    start_ns: int = START_NS,
    namespace: str = "",
) -> dict[str, int]:
    """Write fix, attitude, gimbal, height and, where it is given, the camera.

    Args:
        log: the flight.
        path: the bag's folder; must not exist.
        camera: described with every row, so that live players hear it at once.
        start_ns: time of the log's first row, ns.
        namespace: put before the topics, such as `drone1`.

    Returns:
        Number of messages by topic.

    Raises:
        OutputError: the folder exists, or the disk is full.
    """
    with BagWriter(path, compress=True, namespace=namespace) as bag:
        for stamp_ns, topic, msgtype, fields in messages(log, camera, start_ns):
            bag.write(topic, msgtype, stamp_ns, fields, SENSOR)
        return dict(bag.counts)


def messages(log: DjiLog, camera: CameraModel | None, start_ns: int) -> Iterator[Message]:
    """Yield stamp, topic, type and fields of every message in the order of the log's rows."""
    rows = zip(
        log.fixes(start_ns),
        log.attitudes(start_ns),
        log.gimbals(start_ns),
        log.heights(start_ns),
        strict=True,
    )
    for fix, attitude, gimbal, height in rows:
        stamp_ns = fix.stamp_ns
        if camera is not None:
            info = camera_info_fields(camera, stamp_ns, "camera")
            yield stamp_ns, "camera/camera_info", CAMERA_INFO_TYPE, info
        yield stamp_ns, "fix", FIX_TYPE, fix_fields(fix)
        yield stamp_ns, "attitude", IMU_TYPE, imu_fields(attitude)
        yield stamp_ns, "gimbal", QUATERNION_TYPE, quaternion_fields(gimbal, "enu")
        yield stamp_ns, "height", FLOAT_TYPE, float_fields(height)
