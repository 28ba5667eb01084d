# SPDX-License-Identifier: Apache-2.0
"""Measures both nodes from outside: a camera process before them, a subscriber behind them."""

from __future__ import annotations

import contextlib
import json
import math
import signal
import subprocess
import sys
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
from aerial_gnss_ros.core.errors import RosError
from aerial_gnss_ros.nodes import qos

_READY_S = 60.0
_WARM_UP_S = 2.0
_AFTER_S = 0.5  # the last images' positions are still on their way
_STOP_S = 60.0
_LOOK_S = 0.25
_DETECTOR = "detector: detection"


@dataclass(frozen=True)
class Offer:
    """What is played.

    Attributes:
        bag: folder of the recording.
        images: topic of the images.
        topics: all topics.
        recorded_hz: rate of the images in the bag.
        rate_hz: to play them at.
        count: how many images.
    """

    bag: Path
    images: str
    topics: Sequence[str]
    recorded_hz: float
    rate_hz: float
    count: int


@dataclass
class Live:
    """What was measured.

    Attributes:
        samples_ms: what each stage took for each image, by node.
        offered: images that the camera sent in the time of the measurement.
        processed: of these, those that the detector looked at.
        seconds: that the camera took to send them.
        to_boxes_ms: from an image's stamp to its boxes' arrival at a subscriber.
        to_position_ms: from an image's stamp to a robot's position's arrival.
        start_s: from the start of the nodes' process to the first boxes with a robot.
        processor_s: processor time in the measurement: `nodes`, `camera`, `subscriber`.
        memory_mb: the nodes' process's peak.
        diagnostics: the detector's line at the end.
    """

    samples_ms: dict[str, dict[str, list[float]]] = field(default_factory=dict)
    offered: int = 0
    processed: int = 0
    seconds: float = 0.0
    to_boxes_ms: list[float] = field(default_factory=list)
    to_position_ms: list[float] = field(default_factory=list)
    start_s: float = math.nan
    processor_s: dict[str, float] = field(default_factory=dict)
    memory_mb: float = math.nan
    diagnostics: dict[str, str] = field(default_factory=dict)


class _Subscriber(Node):  # type: ignore[misc]  # rclpy has no complete types
    """Hears boxes and positions; keeps those of images in a span of time."""

    def __init__(self) -> None:
        super().__init__("benchmark")
        self.span = (0, 0)
        self.robots_seen = 0
        self.live = Live()
        self._known: set[str] = set()
        self.create_subscription(Detection2DArray, "detections", self._boxes, qos.detections())
        self.create_subscription(DiagnosticArray, "/diagnostics", self._lines, qos.diagnostics())
        self.create_timer(_LOOK_S, self._look)

    @property
    def now_ns(self) -> int:
        """The clock that images are stamped with."""
        return int(self.get_clock().now().nanoseconds)

    def _look(self) -> None:
        for topic, _ in self.get_topic_names_and_types():
            if topic.startswith("/robots/") and topic.endswith("/fix") and topic not in self._known:
                self._known.add(topic)
                self.create_subscription(NavSatFix, topic, self._position, qos.latched())

    def _boxes(self, array: Any) -> None:
        self.robots_seen = max(self.robots_seen, len(array.detections))
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
    """Play images into both nodes and return what they took; ROS must be initialised.

    Args:
        offer: what is played.
        params: parameter files of the nodes.
        given: parameters, as `name:=value`.
        folder: for the log and the samples.
        report: called with the number of images played.

    Raises:
        RosError: a process ended by itself, or no robot was found; the log's last line says why.
    """
    log, samples = folder / "nodes.log", folder / "samples.json"
    samples.unlink(missing_ok=True)
    camera_command = [
        "camera", str(offer.bag), "--images", offer.images, "--topics", *offer.topics,
        "--rate", str(offer.rate_hz / offer.recorded_hz), "--ros-args",
    ]  # fmt: skip
    words = [word for one in given for word in ("-p", one)]
    files = ["--params", *map(str, params)] if params else []
    pair_command = ["pair", "--samples", str(samples), *files, "--ros-args", *words]
    subscriber = _Subscriber()
    executor = SingleThreadedExecutor()
    executor.add_node(subscriber)
    try:
        with log.open("wb") as file, _process(camera_command, file) as camera:
            watch = _Watch(subscriber, executor, [camera], log)
            watch.until(lambda: subscriber.count_publishers(offer.images) > 0, "no images came")
            with _process(pair_command, file) as pair:
                watch.processes.append(pair)
                live = _measure(watch, pair, camera, offer, report)
        if not samples.is_file():
            raise RosError(f"the nodes did not end well; {watch.last_line()}")
        live.samples_ms = json.loads(samples.read_text(encoding="utf-8"))
    finally:
        executor.shutdown()
        subscriber.destroy_node()
    return live


def _measure(
    watch: _Watch,
    pair: subprocess.Popen[bytes],
    camera: subprocess.Popen[bytes],
    offer: Offer,
    report: Callable[[int], None],
) -> Live:
    subscriber, live = watch.subscriber, watch.subscriber.live
    started = time.monotonic()
    watch.until(lambda: subscriber.robots_seen > 0, "no robot was found in any image")
    live.start_s = time.monotonic() - started
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


@dataclass
class _Watch:
    """Spins the subscriber, and notices when a process ends."""

    subscriber: _Subscriber
    executor: SingleThreadedExecutor
    processes: list[subprocess.Popen[bytes]]
    log: Path

    def spin(self, seconds: float, report: Callable[[float], None] = lambda _s: None) -> None:
        """Spin for some time.

        Raises:
            RosError: a process ended.
        """
        start = time.monotonic()
        while (spent := time.monotonic() - start) < seconds:
            self.executor.spin_once(timeout_sec=min(0.1, seconds - spent))
            report(spent)
            self._check()
        report(seconds)

    def until(self, true: Callable[[], bool], otherwise: str) -> None:
        """Spin until something is so.

        Raises:
            RosError: a process ended, or it was not so for a minute.
        """
        start = time.monotonic()
        while not true():
            self.executor.spin_once(timeout_sec=0.02)
            self._check()
            if time.monotonic() - start > _READY_S:
                raise RosError(f"{otherwise} for {_READY_S:.0f} s; {self.last_line()}")

    def _check(self) -> None:
        for process in self.processes:
            if process.poll() is not None:
                raise RosError(
                    f"a process ended with status {process.returncode}; {self.last_line()}"
                )

    def last_line(self) -> str:
        """Return the last words in the log."""
        lines = self.log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        return f"its last words: {lines[-1] if lines else '(none)'}"


@contextlib.contextmanager
def _process(command: Sequence[str], log: Any) -> Iterator[subprocess.Popen[bytes]]:
    module = f"aerial_gnss_ros.benchmarking.{command[0]}"
    process = subprocess.Popen(  # noqa: S603
        [sys.executable, "-m", module, *command[1:]], stdout=log, stderr=subprocess.STDOUT
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(_STOP_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


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
