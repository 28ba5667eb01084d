# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measures both nodes from outside, between a camera process and a subscriber."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import NavSatFix
from vision_msgs.msg import Detection2DArray

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.benchmarking.machine import peak_memory_mb, processor_s
from aerial_gnss_ros.benchmarking.processes import Watch, process
from aerial_gnss_ros.core.values.errors import RosError
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.transport import VARIABLE, use_large_data_profile

_WARM_UP_S = 2.0
_AFTER_S = 0.5  # the last images' positions are still on their way
_LOOK_S = 0.25
_DETECTOR = "detector: detection"


@dataclass(frozen=True)
class Offer:
    """Settings of the playback.

    Attributes:
        bag: folder of the recording.
        images: topic of the images.
        topics: all topics.
        recorded_hz: rate of the images in the bag.
        rate_hz: to play them at.
        count: how many images.
        starts: number of starts of the nodes; the last one is measured.
    """

    bag: Path
    images: str
    topics: Sequence[str]
    recorded_hz: float
    rate_hz: float
    count: int
    starts: int = 1


@dataclass
class Live:
    """Measurements of both nodes.

    Attributes:
        samples_ms: duration of each stage for each image, by node.
        offered: images that the camera sent during the measurement.
        processed: images that the detector processed.
        seconds: duration of sending them.
        to_boxes_ms: from an image's stamp to its boxes' arrival at a subscriber.
        to_position_ms: from an image's stamp to a robot's position's arrival.
        starts_s: from each start of the nodes' process to the first boxes with a robot.
        processor_s: CPU time during the measurement: `nodes`, `camera`, `subscriber`.
        memory_mb: the nodes' process's peak.
        diagnostics: the detector's line at the end.
    """

    samples_ms: dict[str, dict[str, list[float]]] = field(default_factory=dict)
    offered: int = 0
    processed: int = 0
    seconds: float = 0.0
    to_boxes_ms: list[float] = field(default_factory=list)
    to_position_ms: list[float] = field(default_factory=list)
    starts_s: list[float] = field(default_factory=list)
    processor_s: dict[str, float] = field(default_factory=dict)
    memory_mb: float = math.nan
    diagnostics: dict[str, str] = field(default_factory=dict)


class _Subscriber(Node):  # type: ignore[misc]  # rclpy has no complete types
    """Subscribes to boxes and positions; keeps those of images in a span of time."""

    def __init__(self) -> None:
        super().__init__("benchmark")
        self.span = (0, 0)
        self.looked_since_ns = 0
        self.robot_seen = False
        self.live = Live()
        self._known: set[str] = set()
        self.create_subscription(Detection2DArray, "detections", self._boxes, qos.detections())
        self.create_subscription(DiagnosticArray, "/diagnostics", self._lines, qos.diagnostics())
        self.create_timer(_LOOK_S, self._look)

    def look_anew(self) -> None:
        """Reset the detection of a robot; boxes of images from now on count."""
        self.looked_since_ns, self.robot_seen = self.now_ns, False

    @property
    def now_ns(self) -> int:
        """The clock that stamps images."""
        return int(self.get_clock().now().nanoseconds)

    def _look(self) -> None:
        for topic, _ in self.get_topic_names_and_types():
            if topic.startswith("/robots/") and topic.endswith("/fix") and topic not in self._known:
                self._known.add(topic)
                self.create_subscription(NavSatFix, topic, self._position, qos.latched())

    def _boxes(self, array: Any) -> None:
        if array.detections and nanoseconds(array.header.stamp) >= self.looked_since_ns:
            self.robot_seen = True
        age = self._age_ms(array)
        if age is not None:
            self.live.to_boxes_ms.append(age)
            self.live.processed += 1

    def _position(self, fix: Any) -> None:
        age = self._age_ms(fix)
        if age is not None:
            self.live.to_position_ms.append(age)

    def _lines(self, message: Any) -> None:
        for line in message.status:
            if line.name == _DETECTOR:
                self.live.diagnostics = {value.key: value.value for value in line.values}

    def _age_ms(self, message: Any) -> float | None:
        stamp_ns = nanoseconds(message.header.stamp)
        if not self.span[0] <= stamp_ns < self.span[1]:
            return None
        return (self.now_ns - stamp_ns) / 1e6


def measure(
    offer: Offer,
    params: Sequence[Path],
    given: Sequence[str],
    folder: Path,
    report: Callable[[int], None],
) -> Live:
    """Play images into both nodes and return the measurements; ROS must be initialised.

    Args:
        offer: what is played.
        params: parameter files of the nodes.
        given: parameters, as `name:=value`.
        folder: for the log and the samples.
        report: called with the number of images played.

    Raises:
        RosError: a process ended by itself, or no robot was detected; the log's last line says why.
    """
    log, samples = folder / "nodes.log", folder / "samples.json"
    camera_command = [
        "camera", str(offer.bag), "--images", offer.images, "--topics", *offer.topics,
        "--rate", str(offer.rate_hz / offer.recorded_hz), "--ros-args",
    ]  # fmt: skip
    words = [word for one in given for word in ("-p", one)]
    files = ["--params", *map(str, params)] if params else []
    pair_command = ["pair", "--samples", str(samples), *files, "--ros-args", *words]
    subscriber = _subscriber()
    executor = SingleThreadedExecutor()
    executor.add_node(subscriber)
    try:
        with log.open("wb") as file, process(camera_command, file) as camera:
            watch = Watch(executor, [camera], log)
            watch.until(lambda: subscriber.count_publishers(offer.images) > 0, "no images came")
            for left in reversed(range(offer.starts)):
                samples.unlink(missing_ok=True)
                subscriber.look_anew()
                with process(pair_command, file) as pair:
                    watch.processes = [camera, pair]
                    _wait_for_a_robot(watch, subscriber)
                    if not left:
                        live = _measure(watch, subscriber, pair, camera, offer, report)
                watch.processes = [camera]
        if not samples.is_file():
            raise RosError(f"the nodes did not end cleanly; {watch.last_line()}")
        live.samples_ms = json.loads(samples.read_text(encoding="utf-8"))
    finally:
        executor.shutdown()
        subscriber.destroy_node()
    return live


def _subscriber() -> _Subscriber:
    """Return a subscriber process with the shipped profile, announced twice a second.

    The nodes, which do not have that profile, would otherwise discover it up to 3 s late (see the
    profile).
    """
    chosen = use_large_data_profile()
    try:
        return _Subscriber()
    finally:
        if chosen:
            del os.environ[VARIABLE]


def _wait_for_a_robot(watch: Watch, subscriber: _Subscriber) -> None:
    """Wait for boxes, and record how long it took."""
    started = time.monotonic()
    watch.until(lambda: subscriber.robot_seen, "no robot was detected in any image")
    subscriber.live.starts_s.append(time.monotonic() - started)


def _measure(
    watch: Watch,
    subscriber: _Subscriber,
    pair: subprocess.Popen[bytes],
    camera: subprocess.Popen[bytes],
    offer: Offer,
    report: Callable[[int], None],
) -> Live:
    live = subscriber.live
    watch.spin(_WARM_UP_S)
    pids = {"nodes": pair.pid, "camera": camera.pid}
    pair.send_signal(signal.SIGUSR1)
    before = {name: processor_s(pid) for name, pid in pids.items()}
    own, began_ns = time.process_time(), subscriber.now_ns
    live.seconds, live.offered = offer.count / offer.rate_hz, offer.count
    subscriber.span = (began_ns, began_ns + round(live.seconds * 1e9))
    watch.spin(live.seconds, lambda s: report(min(offer.count, round(s * offer.rate_hz))))
    live.processor_s = {name: processor_s(pid) - before[name] for name, pid in pids.items()}
    live.processor_s["subscriber"] = time.process_time() - own
    watch.spin(_AFTER_S)
    live.memory_mb = peak_memory_mb(pair.pid)
    return live


@contextlib.contextmanager
def ros() -> Iterator[None]:
    """Initialise ROS for a while."""
    rclpy.init(args=[])
    try:
        yield
    finally:
        rclpy.try_shutdown()


def serialise(msgtype: str, fields: dict[str, Any]) -> bytes:
    """Make a message as the nodes do, and its bytes as the middleware does."""
    from rclpy.serialization import serialize_message

    from aerial_gnss_ros.nodes.ros_messages import message

    return bytes(serialize_message(message(msgtype, fields)))
