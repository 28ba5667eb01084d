# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plays a bag into detector and estimator processes and records what they publish.

Everything passes through ROS as aboard a drone: images best effort, boxes and positions reliable.
"""

from __future__ import annotations

import contextlib
import math
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import NavSatFix, NavSatStatus
from vision_msgs.msg import Detection2DArray

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.core.values.errors import RosError
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.player import Player

NODES = ("detector", "estimator")
_READY_S = 60.0
_AFTER_S = 4.0  # longer than max_wait, so that the last images get their answer
_STOP_S = 10.0


@dataclass(frozen=True)
class LivePosition:
    """A position as a subscriber received it.

    Attributes:
        stamp_ns: stamp of its image, ns.
        latitude_deg: WGS84.
        longitude_deg: WGS84.
        covariance: (var East, cov East North, var North), m².
        measured: False if the robot is coasting.
    """

    stamp_ns: int
    latitude_deg: float
    longitude_deg: float
    covariance: tuple[float, float, float]
    measured: bool

    @property
    def sigma(self) -> float:
        """One sigma: root of the mean of both variances, m."""
        return math.sqrt((self.covariance[0] + self.covariance[2]) / 2.0)


@dataclass
class Heard:
    """Output of the nodes during a flight.

    Attributes:
        positions: by robot id, in the order received.
        detections: stamp in ns and Detection2DArray as CDR.
        images: number of images played.
    """

    positions: dict[str, list[LivePosition]] = field(default_factory=dict)
    detections: list[tuple[int, bytes]] = field(default_factory=list)
    images: int = 0


class _Listener(Node):  # type: ignore[misc]  # rclpy has no complete types
    """Subscribes to `detections` and to each robot's fix as soon as it appears."""

    def __init__(self, heard: Heard) -> None:
        super().__init__("listener")
        self._heard = heard
        self._known: set[str] = set()
        self.create_subscription(
            Detection2DArray, "detections", self._take_detections, qos.detections()
        )
        self.create_timer(0.25, self._look_for_robots)

    def _look_for_robots(self) -> None:
        start = self.resolve_topic_name("robots") + "/"
        for topic, _ in self.get_topic_names_and_types():
            robot = topic.removeprefix(start).removesuffix("/fix")
            if topic == f"{start}{robot}/fix" and robot not in self._known:
                self._known.add(robot)
                self.create_subscription(
                    NavSatFix, topic, lambda fix, robot=robot: self._take(robot, fix), qos.latched()
                )

    def _take(self, robot: str, fix: Any) -> None:
        values = fix.position_covariance
        self._heard.positions.setdefault(robot, []).append(
            LivePosition(
                nanoseconds(fix.header.stamp),
                fix.latitude,
                fix.longitude,
                (float(values[0]), float(values[1]), float(values[4])),
                fix.status.status == NavSatStatus.STATUS_FIX,
            )
        )

    def _take_detections(self, array: Any) -> None:
        stamp_ns = nanoseconds(array.header.stamp)
        self._heard.detections.append((stamp_ns, bytes(serialize_message(array))))


def fly(
    bag: BagReader,
    topics: list[str],
    log: Path,
    on_tick: Callable[[float, Mapping[str, list[LivePosition]]], None],
    rate: float = 1.0,
    detector: Mapping[str, str] | None = None,
    estimator: Mapping[str, object] | None = None,
) -> Heard:
    """Play a bag into real nodes; ROS must be initialised.

    Args:
        bag: open; its images and telemetry.
        topics: absolute names to play.
        log: file for the nodes' output.
        on_tick: called about five times a second with seconds since the start of the bag and
            the positions heard so far.
        rate: 1 plays in real time, 0.5 takes twice as long.
        detector: non-default parameters of the detector, by dotted name.
        estimator: the same of the estimator.

    Raises:
        RosError: a node ended by itself, or a topic has no subscriber; the log's last line says
            why.
    """
    heard = Heard()
    own = {"detector": detector or {}, "estimator": estimator or {}}
    with _nodes(log, topics, own) as processes, _spinning(_Listener(heard)):
        node = rclpy.create_node("player")
        player = Player(node, bag, topics, rate)
        missing = player.wait_for_subscribers(topics, _READY_S)
        if missing:
            raise RosError(f"nobody listens to {', '.join(missing)}; {_last_line(log)}")
        ticking = _Ticks(processes, lambda elapsed: on_tick(elapsed, heard.positions))
        end_ns = player.play(ticking)
        player.run_on(end_ns, _AFTER_S, ticking)
        ticking.check(log)
        heard.images = max(player.published.get(t, 0) for t in topics if "/image" in t)
        node.destroy_node()
    return heard


class _Ticks:
    """Decides whether to continue playing, and calls back periodically."""

    def __init__(
        self, processes: list[subprocess.Popen[bytes]], on_tick: Callable[[float], None]
    ) -> None:
        self._processes = processes
        self._on_tick = on_tick
        self._clock = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        self._start = self._clock.now().nanoseconds
        self._next_s = 0.0

    def __call__(self) -> bool:
        elapsed_s = (self._clock.now().nanoseconds - self._start) * 1e-9
        if elapsed_s >= self._next_s:
            self._next_s = elapsed_s + 0.2
            self._on_tick(elapsed_s)
        return rclpy.ok() and all(process.poll() is None for process in self._processes)

    def check(self, log: Path) -> None:
        for name, process in zip(NODES, self._processes, strict=True):
            if process.poll() is not None:
                raise RosError(
                    f"the {name} ended with status {process.returncode}; {_last_line(log)}"
                )


@contextlib.contextmanager
def _nodes(
    log: Path, topics: list[str], own: Mapping[str, Mapping[str, object]]
) -> Iterator[list[subprocess.Popen[bytes]]]:
    processes: list[subprocess.Popen[bytes]] = []
    if any(topic.endswith("/compressed") for topic in topics):
        own = {**own, "detector": {**own["detector"], "image.transport": "compressed"}}
    with log.open("wb") as file:
        try:
            for name in NODES:
                command = [sys.executable, "-m", f"aerial_gnss_ros.nodes.{name}"]
                command += ["--ros-args", "-p", "use_sim_time:=true"]
                for key, value in own[name].items():
                    command += ["-p", f"{key}:={value}"]
                processes.append(
                    subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)  # noqa: S603
                )
            yield processes
        finally:
            for process in processes:
                process.send_signal(signal.SIGINT)
            for process in processes:
                _await_end(process)


def _await_end(process: subprocess.Popen[bytes]) -> None:
    try:
        process.wait(_STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()


@contextlib.contextmanager
def _spinning(node: Node) -> Iterator[None]:
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    try:
        yield
    finally:
        executor.shutdown()
        thread.join(_STOP_S)
        node.destroy_node()


def _last_line(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return f"{log} ends with: {lines[-1] if lines else '(nothing)'}"
