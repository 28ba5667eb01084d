# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated flight played into both nodes, live, each in processes of its own."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from rclpy.executors import SingleThreadedExecutor

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.benchmarking.machine import children
from aerial_gnss_ros.core.values.errors import RosError

IMAGES = "/camera/image_raw"
SENSORS = (IMAGES, "/camera/camera_info", "/fix", "/attitude", "/gimbal", "/height")


def spin(
    executor: SingleThreadedExecutor,
    seconds: float,
    processes: tuple[subprocess.Popen[bytes], ...],
    log: Path,
) -> None:
    """Listen for some time.

    Raises:
        RosError: the camera or the supervisor ended.
    """
    until_s = time.monotonic() + seconds
    while (left_s := until_s - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=min(0.1, left_s))
        if any(process.poll() is not None for process in processes):
            raise RosError(f"a process ended; see {log}")


def by_name(pid: int) -> dict[str, int]:
    """Return the nodes' processes by name, children of the supervisor `pid`."""
    return {
        words[words.index("--node") + 1]: child
        for child, words in children(pid).items()
        if "--node" in words
    }


@contextmanager
def camera_process(bag: Path, log: IO[bytes], *options: str) -> Iterator[subprocess.Popen[bytes]]:
    """Play a flight without end; lines on its standard input disturb it."""
    with open_bag([bag]) as reader:
        truth = [name for name in reader.topics if name.startswith("/truth/robots/")]
    command = [
        sys.executable, "-m", "aerial_gnss_ros.benchmarking.camera", str(bag), "--disturb",
        *options, "--images", IMAGES, "--topics", *SENSORS, *truth, "--ros-args",
    ]  # fmt: skip
    with _process(command, log) as process:
        yield process


@contextmanager
def node_processes(log: IO[bytes], *parameters: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run detector and estimator as a user does; the process is their supervisor."""
    command = [
        sys.executable, "-m", "aerial_gnss_ros.cli", "run", "--ros-args",
        *(word for one in ("search.mode:=roi", *parameters) for word in ("-p", one)),
    ]  # fmt: skip
    with _process(command, log) as process:
        yield process


@contextmanager
def _process(command: list[str], log: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(  # noqa: S603
        command, stdin=subprocess.PIPE, stdout=log, stderr=subprocess.STDOUT
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
