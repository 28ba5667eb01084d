# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs and watches a benchmark's other processes."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rclpy.executors import SingleThreadedExecutor

from aerial_gnss_ros.core.values.errors import RosError

_READY_S = 60.0
_STOP_S = 60.0


@dataclass
class Watch:
    """Spins an executor, and notices when a process ends."""

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
        """Spin until a condition is true.

        Raises:
            RosError: a process ended, or the condition was false for a minute.
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
def process(command: Sequence[str], log: Any) -> Iterator[subprocess.Popen[bytes]]:
    """Run a module of this package for a while; it is ended by SIGINT.

    Args:
        command: the module's name and its arguments.
        log: open file for what it prints.
    """
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
