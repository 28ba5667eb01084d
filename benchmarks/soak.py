# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Do the nodes stay the same over hours? Both live, with a fault a minute.

python benchmarks/soak.py --minutes 60 -o soak

A simulated flight over three robots is played to and fro, with stamps that go on: images at 30 Hz,
telemetry at 50 Hz. The nodes run as `aerial-gnss run` starts them. Each minute one fault is put in
(`benchmarking/disturbing.py`), kinds in turn; with --kill a node is killed as well. Once a minute
memory, descriptors and threads of each process are read, and what a subscriber heard. Memory that
is shared with other processes stands apart (`soak_judge.py` says why).
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import rclpy
from live_flight import by_name, camera_process, node_processes, spin
from rclpy.executors import SingleThreadedExecutor
from soak_judge import Minute, Usage, minute_of, verdict
from soak_listener import Listener
from tables import columns

from aerial_gnss_ros.benchmarking.disturbing import SECONDS
from aerial_gnss_ros.benchmarking.flight import flight, render
from aerial_gnss_ros.benchmarking.machine import (
    descriptors,
    own_memory_mb,
    processor_s,
    segments_mb,
    shared_memory_mb,
    threads,
)

KILLS = ("detector", "estimator")
FAULT_S = 20.0  # within the minute
SETTLE_S = 40.0  # for the first positions


def main() -> int:
    """Run the nodes, and say how they did."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=int, default=60, help="default 60, at least 3")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360), help="of the images, px")
    parser.add_argument("--kill", action="store_true", help="kill a node now and then, too")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, default=Path("soak"), help="folder")
    parser.add_argument("--report", type=Path, metavar="JSONL", help="only judge a former run")
    args = parser.parse_args()
    if args.report:
        lines = args.report.read_text(encoding="utf-8").splitlines()
        print(_report([minute_of(json.loads(line)) for line in lines]))
        return 0
    if args.minutes < 3:
        parser.error("--minutes must be at least 3")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    args.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="soak_") as folder:
        bag = Path(folder) / "flight"
        render(flight(3, tuple(args.size), args.seed), bag, args.seed, lambda _n: None)
        minutes = _soak(bag, args)
    table = _report(minutes)
    (args.output / "soak.md").write_text(table, encoding="utf-8")
    print(table)
    return 0 if all(finding.passed for finding in verdict(minutes)) else 1


def _soak(bag: Path, args: argparse.Namespace) -> list[Minute]:
    rclpy.init(args=[])
    listener, executor = Listener(), SingleThreadedExecutor()
    executor.add_node(listener)
    minutes: list[Minute] = []
    log = args.output / "nodes.log"
    kinds = itertools.cycle([*SECONDS, *(f"{name} killed" for name in KILLS if args.kill)])
    with log.open("wb") as file, camera_process(bag, file) as camera, node_processes(file) as nodes:
        spin(executor, SETTLE_S, (camera, nodes), log)
        listener.minute()
        for kind in itertools.islice(kinds, args.minutes):
            minute = Minute(kind, provoked=minutes[-1].provoked if minutes else 0)
            spin(executor, FAULT_S, (camera, nodes), log)
            _provoke(kind, camera, nodes, minute)
            spin(executor, 60.0 - FAULT_S, (camera, nodes), log)
            _note(minute, listener, nodes, log)
            minutes.append(minute)
            _keep(args.output / "soak.jsonl", minute)
    executor.shutdown()
    listener.destroy_node()
    rclpy.try_shutdown()
    return minutes


def _provoke(
    kind: str, camera: subprocess.Popen[bytes], nodes: subprocess.Popen[bytes], minute: Minute
) -> None:
    if kind in SECONDS:
        assert camera.stdin is not None  # noqa: S101 - a pipe
        camera.stdin.write(f"{kind}\n".encode())
        camera.stdin.flush()
        return
    os.kill(by_name(nodes.pid)[kind.split(maxsplit=1)[0]], signal.SIGKILL)
    minute.provoked += 1


def _note(minute: Minute, listener: Listener, nodes: subprocess.Popen[bytes], log: Path) -> None:
    heard = listener.minute()
    minute.delay_ms, minute.control_ms = heard["delay_ms"], heard["control_ms"]
    minute.load = os.getloadavg()[0]
    minute.positions_hz, minute.wrong = heard["positions"] / 60.0, heard["wrong"]
    minute.ended = log.read_text(encoding="utf-8", errors="replace").count("it is restarted")
    for name, pid in {"supervisor": nodes.pid, **by_name(nodes.pid)}.items():
        minute.usage[name] = Usage(
            pid,
            own_memory_mb(pid),
            descriptors(pid),
            threads(pid),
            shared_memory_mb(pid),
            segments_mb(pid),
            processor_s(pid),
        )


def _keep(path: Path, minute: Minute) -> None:
    with path.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(dataclasses.asdict(minute)) + "\n")
    used = ", ".join(
        f"{name} {one.memory_mb:.1f} MB + {one.shared_mb:.1f} MB shared of {one.segments_mb:.1f} "
        f"{one.descriptors} descriptors {one.threads} threads"
        for name, one in minute.usage.items()
    )
    print(
        f"{minute.fault}: {minute.positions_hz:.1f} positions a second, {minute.wrong} wrong, "
        f"delay {minute.delay_ms[0]:.1f} / {minute.delay_ms[1]:.1f} ms; {used}",
        flush=True,
    )


def _report(minutes: list[Minute]) -> str:
    heads = [
        "minute", "fault", "positions a second", "wrong", "delay ms: median", "95 of 100", "load",
    ]  # fmt: skip
    heads += [f"{name} MB + shared" for name in minutes[0].usage]
    rows = [
        [
            str(i + 1), one.fault, f"{one.positions_hz:.1f}", str(one.wrong),
            f"{one.delay_ms[0]:.1f}", f"{one.delay_ms[1]:.1f}", f"{one.load:.1f}",
            *(f"{used.memory_mb:.1f} + {used.shared_mb:.1f}" for used in one.usage.values()),
        ]
        for i, one in enumerate(minutes)
    ]  # fmt: skip
    found = [[one.what, one.value, "yes" if one.passed else "NO"] for one in verdict(minutes)]
    control = [minutes[0].control_ms, minutes[-1].control_ms]
    return (
        f"{columns(['after the warm-up', 'value', 'passed'], found)}\n"
        f"Of the delay the machine and the camera process: "
        f"{control[0][0]:.1f} to {control[1][0]:.1f} ms.\n\n"
        f"{columns(heads, rows)}"
    )


if __name__ == "__main__":
    sys.exit(main())
