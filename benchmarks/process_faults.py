# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of live positions when a process, a disk or a clock fails.

python benchmarks/process_faults.py --markdown process_faults.md

Both nodes run as `aerial-gnss run` starts them, over a simulated flight with three robots, images
at 30 Hz, with simulated time (/clock), so that the clock of all can be stepped. Each fault waits
until all robots are measured. `ready`: from its end until the nodes that were killed publish
diagnostics again. `right after`: from then until as many robots as before are measured.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import rclpy
from live_flight import by_name, camera_process, node_processes, spin
from rclpy.executors import SingleThreadedExecutor
from soak_listener import Listener
from tables import columns, show

from aerial_gnss_ros.benchmarking.flight import flight, render
from aerial_gnss_ros.core.values.errors import RosError

SETTLE_S = 90.0
"""The longest wait for all robots to be measured before a fault, s."""
AFTER_S = 25.0
"""How long each fault is watched from its end on, s."""
FRESH_S = 1.0
"""A robot is measured while its last position is measured and no older, s."""
IN_FLIGHT_S = 0.3
"""Messages of a killed node may still arrive for so long, s."""
SIZE = (640, 360)
NODES = ("detector", "estimator")

Wait = Callable[[float], None]


@dataclasses.dataclass
class Live:
    """What a fault can act on.

    Attributes:
        camera: plays the flight; takes disturbances on its standard input.
        nodes: the supervisor of both nodes.
        wait: listens for so many seconds.
        state: the state file of the estimator.
    """

    camera: subprocess.Popen[bytes]
    nodes: subprocess.Popen[bytes]
    wait: Wait
    state: Path

    def pid(self, name: str) -> int:
        """Return a node's process."""
        return by_name(self.nodes.pid)[name]

    def disturb(self, kind: str) -> None:
        """Let the camera disturb what it plays."""
        assert self.camera.stdin is not None  # noqa: S101 - a pipe
        self.camera.stdin.write(f"{kind}\n".encode())
        self.camera.stdin.flush()


def killed(*names: str) -> Callable[[Live], None]:
    """Return a fault that kills nodes as a crash does."""

    def fault(live: Live) -> None:
        for name in names:
            os.kill(live.pid(name), signal.SIGKILL)

    return fault


def stopped(name: str) -> Callable[[Live], None]:
    """Return a fault in which a node gets no processor time for 5 s."""

    def fault(live: Live) -> None:
        pid = live.pid(name)
        os.kill(pid, signal.SIGSTOP)
        live.wait(5.0)
        os.kill(pid, signal.SIGCONT)

    return fault


def slow(live: Live) -> None:
    """Give the detector a tenth of the time for 10 s: about three images a second."""
    pid = live.pid("detector")
    for _ in range(25):
        os.kill(pid, signal.SIGSTOP)
        live.wait(0.36)
        os.kill(pid, signal.SIGCONT)
        live.wait(0.04)


def disk_full(live: Live) -> None:
    """Let no file of the estimator grow for 5 s, as on a full disk: state file, names, log."""
    pid = live.pid("estimator")
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
    live.wait(5.0)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, before)


def subscriber_lost(live: Live) -> None:
    """Kill a subscriber of a robot's positions that was listening, reliable and latched."""
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", "stream", "--cot", "127.0.0.1:9"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT) as other:  # noqa: S603
        live.wait(8.0)
        other.kill()


def stepped(kind: str) -> Callable[[Live], None]:
    """Return a fault that steps the clock that stamps everything."""
    return lambda live: live.disturb(kind)


KILLED = {
    "detector killed": ("detector",),
    "estimator killed": ("estimator",),
    "both killed": NODES,
}
"""Faults that kill nodes, and which."""

FAULTS: dict[str, Callable[[Live], None]] = {
    **{words: killed(*names) for words, names in KILLED.items()},
    "detector stands for 5 s": stopped("detector"),
    "estimator stands for 5 s": stopped("estimator"),
    "detector ten times as slow for 10 s": slow,
    "disk full for 5 s": disk_full,
    "clock steps an hour ahead": stepped("clock steps an hour ahead"),
    "clock steps back": stepped("clock steps back"),
    "subscriber lost": subscriber_lost,
}


@dataclasses.dataclass
class Outcome:
    """What became of one fault.

    Attributes:
        fault: its words.
        died: whether a process ended that nobody killed.
        silent_s: the longest time in which no robot was published, predicted or measured.
        ready_s: from the fault's end until killed nodes run and are heard again, s.
        right_s: from then until as many robots are measured as before; infinite: not in time.
        kept: names known before that are measured after it.
        names: known before.
        new: names that came.
        wrong: measured positions beyond 4 sigma and 5 m from every true robot.
        positions: measured positions.
    """

    fault: str
    died: bool
    silent_s: float
    ready_s: float
    right_s: float
    kept: int
    names: int
    new: int
    wrong: int
    positions: int


def fly(live: Live, listener: Listener, name: str) -> Outcome:
    """Put in one fault and watch."""
    _settle(live, listener)
    before, every = _measured(listener), set(listener.names)
    listener.minute()
    pids, restarted = by_name(live.nodes.pid), KILLED.get(name, ())
    listener.silent_s = 0.0
    FAULTS[name](live)
    began = time.monotonic()
    said = began + IN_FLIGHT_S
    ready_s, right_s = math.inf, math.inf
    while (now := time.monotonic()) < began + AFTER_S:
        live.wait(0.1)
        if ready_s == math.inf and all(listener.reported[one] > said for one in restarted):
            ready_s = now - began
        again = {one for one in _measured(listener) if listener.last[one][0] > began}
        if right_s == math.inf and ready_s < math.inf and len(again) == len(before):
            right_s = now - began
    after = by_name(live.nodes.pid)
    changed = {one for one in pids if after.get(one) != pids[one]}
    heard = listener.minute()
    return Outcome(
        name,
        changed != set(restarted),
        listener.silent_s,
        ready_s if restarted else 0.0,
        right_s - (ready_s if restarted else 0.0),
        len(before & _measured(listener)),
        len(before),
        len(set(listener.names) - every),
        heard["wrong"],
        heard["positions"],
    )


def _measured(listener: Listener) -> set[str]:
    since = time.monotonic() - FRESH_S
    return {name for name, (at, measured) in listener.last.items() if measured and at > since}


def _settle(live: Live, listener: Listener) -> None:
    """Wait until all true robots are measured.

    Raises:
        RosError: they are not in time.
    """
    until = time.monotonic() + SETTLE_S
    while time.monotonic() < until:
        live.wait(1.0)
        if len(_measured(listener)) == listener.robots > 0:
            live.wait(3.0)
            return
    raise RosError(f"{len(_measured(listener))} of {listener.robots} robots were measured")


@contextmanager
def _session(folder: Path, log: Path) -> Iterator[tuple[Live, Listener]]:
    bag = folder / "flight"
    render(flight(3, SIZE, 1), bag, 1, lambda _count: None)
    rclpy.init(args=[])
    listener, executor = Listener(simulated_time=True), SingleThreadedExecutor()
    executor.add_node(listener)
    state = folder / "names.json"
    parameters = ("use_sim_time:=true", f"state_file:={state}")
    with (
        log.open("wb") as file,
        camera_process(bag, file, "--clock") as camera,
        node_processes(file, *parameters) as nodes,
    ):
        both = (camera, nodes)
        yield Live(camera, nodes, lambda s: spin(executor, s, both, log), state), listener
    executor.shutdown()
    listener.destroy_node()
    rclpy.try_shutdown()


def table(outcomes: list[Outcome]) -> str:
    """Return the outcomes as a table in Markdown."""
    heads = ["fault", "a process died by itself", "silent s", "ready s", "right after s"]
    heads += ["names kept", "new names", "wrong positions"]
    rows = [
        [
            one.fault, "YES" if one.died else "no", f"{one.silent_s:.1f}",
            f"{one.ready_s:.1f}" if one.ready_s else "–",
            f"{one.right_s:.1f}" if math.isfinite(one.right_s) else "never",
            f"{one.kept} of {one.names}", str(one.new), f"{one.wrong} of {one.positions}",
        ]
        for one in outcomes
    ]  # fmt: skip
    return columns(heads, rows)


def main() -> int:
    """Put in all faults and show the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=FAULTS, default=list(FAULTS))
    parser.add_argument("--log", type=Path, default=Path("process_faults.log"), help="of the nodes")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    outcomes = []
    with (
        tempfile.TemporaryDirectory(prefix="process_faults_") as folder,
        _session(Path(folder), given.log) as (live, listener),
    ):
        for name in given.only:
            outcomes.append(fly(live, listener, name))
            print(outcomes[-1], file=sys.stderr, flush=True)
    show(table(outcomes), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
