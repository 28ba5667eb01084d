# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes a simulated flight as a rosbag2: sensors, images or detections, and the truth."""

from __future__ import annotations

import heapq
import itertools
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import telemetry_fields as fields
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.typestore import serialize
from aerial_gnss_ros.bags.writer import RELIABLE, SENSOR, BagVersion, BagWriter
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.simulation.boxes import Boxes
from aerial_gnss_ros.simulation.experiment import CAMERA_FRAME, Experiment, Frame
from aerial_gnss_ros.simulation.imaging import WORKERS, Picture, Rendered, render_all
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.sensors import START_NS
from aerial_gnss_ros.simulation.water_photograph import WaterPhotograph

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
IMAGE_TYPES = {"jpeg": "sensor_msgs/msg/CompressedImage", "raw": "sensor_msgs/msg/Image"}
IMAGE_TOPICS = {"jpeg": "camera/image_raw/compressed", "raw": "camera/image_raw"}
JPEG_QUALITY = 92

Report = Callable[[int], None]


@dataclass(frozen=True)
class _Message:
    log_ns: int
    topic: str
    msgtype: str
    data: bytes
    reliable: bool = False


def write_bag(
    path: Path,
    experiment: Experiment,
    scene: Scene | None,
    *,
    images: str = "jpeg",
    scenario: dict[str, Any] | None = None,
    workers: int = WORKERS,
    report: Report | None = None,
    version: BagVersion | None = None,
    water: WaterPhotograph | None = None,
) -> dict[str, int]:
    """Write a flight; equal experiments give equal bytes.

    Args:
        path: the bag's folder, which must not exist.
        experiment: the flight.
        scene: appearance of the scene; None: no images, but the `detections` of a simulated
            detector.
        images: `jpeg` (CompressedImage) or `raw` (Image, the bag zstd-compressed).
        scenario: description of the simulation, recorded as JSON on `truth/scenario`.
        workers: rendering processes; 0 renders in this one.
        report: called with the number of images done.
        version: of the bag's files, see `BagWriter`.
        water: a photograph in place of the scene's water.

    Returns:
        Number of messages by topic.

    Raises:
        OutputError: the bag exists already, cannot be written, or the disk is full.
    """
    frames = experiment.frames()
    if scene is None:
        moments = _simulated(experiment)
    else:
        moments = _photographed(experiment, frames, scene, images, workers, water)
    compress = images == "raw" and scene is not None
    with BagWriter(path, compress=compress, version=version) as bag:
        seen = itertools.chain.from_iterable(_reported(moments, report))
        small = _telemetry(experiment, scenario or {})
        for message in heapq.merge(small, seen, key=lambda message: message.log_ns):
            qos = RELIABLE if message.reliable else SENSOR
            bag.write(message.topic, message.msgtype, message.log_ns, message.data, qos)
        return dict(bag.counts)


def _reported(moments: Iterator[list[_Message]], report: Report | None) -> Iterator[list[_Message]]:
    for done, moment in enumerate(moments, start=1):
        yield moment
        if report is not None:
            report(done)


def _photographed(
    experiment: Experiment,
    frames: list[Frame],
    scene: Scene,
    images: str,
    workers: int,
    water: WaterPhotograph | None,
) -> Iterator[list[_Message]]:
    pictures = (Picture(f.pose, f.t, experiment.states(f), experiment.props) for f in frames)
    quality = JPEG_QUALITY if images == "jpeg" else None
    rendered = render_all(pictures, scene, experiment.camera, quality, workers, water)
    for frame, picture in zip(frames, rendered, strict=True):
        boxes = _labelled([label for label in picture.labels if label.clear])
        yield [
            _camera_info(experiment, frame),
            _image(experiment, frame, picture, images),
            _true_boxes(frame, boxes),
            _labels(frame, picture.labels),
        ]


def _simulated(experiment: Experiment) -> Iterator[list[_Message]]:
    for frame, boxes, found in experiment.detections():
        yield [
            _camera_info(experiment, frame),
            _true_boxes(frame, boxes),
            _detections(frame, found),
        ]


def _telemetry(experiment: Experiment, scenario: dict[str, Any]) -> Iterator[_Message]:
    """Yield everything but images and boxes in the order of arrival."""
    streams = [
        message for stream in (_measured(experiment), _truth(experiment)) for message in stream
    ]
    streams.sort(key=lambda message: message.log_ns)  # stable: equal times keep the topics' order
    about = json.dumps(scenario, sort_keys=True)
    first = streams[0].log_ns if streams else START_NS
    yield _message(first, "truth/scenario", "std_msgs/msg/String", {"data": about}, reliable=True)
    yield from streams


def _measured(experiment: Experiment) -> Iterator[_Message]:
    sensors, plan = experiment.sensors, experiment.sensors_plan
    for fix in sensors.fixes():
        log = fix.stamp_ns + _ns(plan.fix_latency_s)
        yield _message(log, "fix", fields.FIX_TYPE, fields.fix_fields(fix))
    for attitude in sensors.attitudes():
        log = attitude.stamp_ns + _ns(plan.attitude_latency_s)
        yield _message(log, "attitude", fields.IMU_TYPE, fields.imu_fields(attitude))
    for gimbal in sensors.gimbals():
        log = gimbal.stamp_ns + _ns(plan.gimbal_latency_s)
        values = fields.quaternion_fields(gimbal, "enu")
        yield _message(log, "gimbal", fields.QUATERNION_TYPE, values)
    for height in sensors.heights():
        log = height.stamp_ns + _ns(plan.height_latency_s)
        yield _message(log, "height", fields.FLOAT_TYPE, fields.float_fields(height))


def _truth(experiment: Experiment) -> Iterator[_Message]:
    """Yield the truth, which arrives at once."""
    sensors = experiment.sensors
    for name, path in experiment.robot_fixes():
        for fix in path:
            values = fields.fix_fields(fix, name)
            yield _message(
                fix.stamp_ns, f"truth/robots/{name}/fix", fields.FIX_TYPE, values, reliable=True
            )
    for fix in sensors.fixes(true=True):
        values = fields.fix_fields(fix)
        yield _message(fix.stamp_ns, "truth/fix", fields.FIX_TYPE, values, reliable=True)
    for attitude in sensors.attitudes(true=True):
        values = fields.imu_fields(attitude)
        yield _message(attitude.stamp_ns, "truth/attitude", fields.IMU_TYPE, values, reliable=True)
    for gimbal in sensors.gimbals(true=True):
        values = fields.quaternion_fields(gimbal, "enu")
        yield _message(
            gimbal.stamp_ns, "truth/gimbal", fields.QUATERNION_TYPE, values, reliable=True
        )
    for height in sensors.heights(true=True):
        values = fields.float_fields(height)
        yield _message(height.stamp_ns, "truth/height", fields.FLOAT_TYPE, values, reliable=True)


def _camera_info(experiment: Experiment, frame: Frame) -> _Message:
    values = fields.camera_info_fields(experiment.camera, frame.stamp_ns, CAMERA_FRAME)
    return _message(frame.log_ns, "camera/camera_info", fields.CAMERA_INFO_TYPE, values)


def _image(experiment: Experiment, frame: Frame, rendered: Rendered, kind: str) -> _Message:
    camera = experiment.camera
    values: dict[str, Any] = {
        "header": header_fields(frame.stamp_ns, CAMERA_FRAME),
        "data": rendered.data,
    }
    if kind == "jpeg":
        values["format"] = "bgr8; jpeg compressed bgr8"
    else:
        values |= {
            "height": camera.height,
            "width": camera.width,
            "encoding": "bgr8",
            "step": 3 * camera.width,
        }
    return _message(frame.log_ns, IMAGE_TOPICS[kind], IMAGE_TYPES[kind], values)


def _labelled(labels: list[RobotLabel]) -> Boxes:
    xywh = np.array([label.xywh for label in labels], dtype=np.float64).reshape(-1, 4)
    return Boxes(
        tuple(label.robot_id for label in labels),
        tuple(label.class_name for label in labels),
        xywh[:, :2],
        xywh[:, 2:],
    )


def _true_boxes(frame: Frame, boxes: Boxes) -> _Message:
    found = DetectionFrame(
        frame.stamp_ns, CAMERA_FRAME, boxes.centers, boxes.sizes, np.ones(len(boxes.names)),
        boxes.class_names,
    )  # fmt: skip
    values = _array(found)
    for box, name in zip(values["detections"], boxes.names, strict=True):
        box["id"] = name
    return _message(frame.log_ns, "truth/detections", DETECTIONS_TYPE, values, reliable=True)


def _labels(frame: Frame, labels: list[RobotLabel]) -> _Message:
    """All robots that are partly in the image, including those too faint or truncated for a box."""
    robots = [
        {"robot_id": label.robot_id, "class": label.class_name, **label.figures()}
        for label in labels
    ]
    values = {"data": json.dumps({"stamp_ns": frame.stamp_ns, "robots": robots})}
    return _message(frame.log_ns, "truth/labels", "std_msgs/msg/String", values, reliable=True)


def _detections(frame: Frame, found: DetectionFrame) -> _Message:
    return _message(frame.log_ns, "detections", DETECTIONS_TYPE, _array(found), reliable=True)


def _array(found: DetectionFrame) -> dict[str, Any]:
    names = tuple(sorted(set(found.class_ids)))
    index = np.array([names.index(name) for name in found.class_ids], dtype=np.int64)
    boxes = Detections(np.hstack([found.centers, found.sizes]), found.scores, index, names)
    return detection_array(boxes, header_fields(found.stamp_ns, found.frame_id))


def _message(
    log_ns: int, topic: str, msgtype: str, values: dict[str, Any], reliable: bool = False
) -> _Message:
    return _Message(log_ns, topic, msgtype, serialize(msgtype, values), reliable)


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)
