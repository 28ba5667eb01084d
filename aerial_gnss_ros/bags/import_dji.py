# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Converts a DJI flight record, with or without video, to a bag on canonical topics."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.dji_log import DjiLog
from aerial_gnss_ros.adapters.stamps import header_fields
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
from aerial_gnss_ros.bags.video import Video
from aerial_gnss_ros.bags.writer import LATCHED, SENSOR, BagVersion, BagWriter
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.samples import Scalar

START_NS = 1_735_689_600_000_000_000
"""Time of the log's first row if neither log nor user gives one: 2025-01-01, 0 h UTC."""

IMAGE_TOPIC = "camera/image_raw/compressed"
IMAGE_TYPE = "sensor_msgs/msg/CompressedImage"

Message = tuple[int, str, str, dict[str, Any]]


@dataclass(frozen=True)
class Footage:
    """A video and the settings of its import.

    Attributes:
        video: the file.
        start_s: its start in the log's time, s.
        every: every n-th frame is imported.
        quality: of the JPEGs, 1 to 100.
    """

    video: Video
    start_s: float
    every: int = 1
    quality: int = 95


def write_dji_bag(
    log: DjiLog,
    path: Path,
    *,
    camera: CameraModel | None = None,
    footage: Footage | None = None,
    start_ns: int = START_NS,
    water_level: float | None = None,
    namespace: str = "",
    on_message: Callable[[int], None] = lambda _done: None,
    version: BagVersion | None = None,
) -> dict[str, int]:
    """Write fix, attitude, gimbal and height, and camera and images if given.

    Args:
        log: the flight.
        path: the bag's folder; must not exist.
        camera: published with every image, or with every row without images, so that live players
            receive it at once.
        footage: the video.
        start_ns: Unix time of the log's time zero, ns.
        water_level: level of the water above the take-off point, m; None: not written.
        namespace: prefix of the topics, such as `drone1`.
        on_message: called with the number of messages written so far.
        version: of the bag's files, see `BagWriter`.

    Returns:
        Number of messages by topic.

    Raises:
        InputError: the video is damaged.
        OutputError: the folder exists, or the disk is full.
    """
    rows = messages(log, None if footage else camera, start_ns, water_level)
    streams = [rows] if footage is None else [rows, images(footage, camera, start_ns)]
    with BagWriter(path, compress=footage is None, namespace=namespace, version=version) as bag:
        merged = heapq.merge(*streams, key=lambda message: message[0])
        for done, (stamp_ns, topic, msgtype, fields) in enumerate(merged, start=1):
            qos = LATCHED if topic == "water_level" else SENSOR
            bag.write(topic, msgtype, stamp_ns, fields, qos)
            on_message(done)
        return dict(bag.counts)


def messages(
    log: DjiLog, camera: CameraModel | None, start_ns: int, water_level: float | None = None
) -> Iterator[Message]:
    """Yield stamp, topic, type and fields of the telemetry in row order."""
    attitudes, gimbals = log.attitudes(start_ns), log.gimbals(start_ns)
    heights = {height.stamp_ns: height for height in log.heights(start_ns)}
    if water_level is not None:
        first_ns = start_ns + int(log.stamps_ns[0])
        level = Scalar(first_ns, water_level)
        yield first_ns, "water_level", FLOAT_TYPE, float_fields(level)
    for i, fix in enumerate(log.fixes(start_ns)):
        stamp_ns = fix.stamp_ns
        if camera is not None:
            info = camera_info_fields(camera, stamp_ns, "camera")
            yield stamp_ns, "camera/camera_info", CAMERA_INFO_TYPE, info
        yield stamp_ns, "fix", FIX_TYPE, fix_fields(fix)
        if attitudes:
            yield stamp_ns, "attitude", IMU_TYPE, imu_fields(attitudes[i])
        if gimbals:
            yield stamp_ns, "gimbal", QUATERNION_TYPE, quaternion_fields(gimbals[i], "enu")
        if stamp_ns in heights:
            yield stamp_ns, "height", FLOAT_TYPE, float_fields(heights[stamp_ns])


def images(footage: Footage, camera: CameraModel | None, start_ns: int) -> Iterator[Message]:
    """Yield the video's frames, each after the camera's description."""
    begin_ns = start_ns + round(footage.start_s * 1e9)
    for seconds, jpeg in footage.video.jpegs(footage.every, footage.quality):
        stamp_ns = begin_ns + round(seconds * 1e9)
        if camera is not None:
            info = camera_info_fields(camera, stamp_ns, "camera")
            yield stamp_ns, "camera/camera_info", CAMERA_INFO_TYPE, info
        header = header_fields(stamp_ns, "camera")
        yield stamp_ns, IMAGE_TOPIC, IMAGE_TYPE, {"header": header, "format": "jpeg", "data": jpeg}
