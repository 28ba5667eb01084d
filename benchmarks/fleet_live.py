# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two live drones and the fleet in two networks with a router between them, over DDS.

sudo unshare --net python benchmarks/fleet_live.py --markdown docs/results/fleet.md

Estimators and player are processes in one network namespace, the fleet is one in another; this
process's namespace routes between them and counts bytes, headers and discovery included. No
multicast passes: they find each other by ROS_STATIC_PEERS. In Linux, as root.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tables import columns, show

IP = shutil.which("ip") or "ip"
SIDES = {"drones": "10.71.1", "shore": "10.71.2"}
FLOWN_S = 20.0
IDLE_S = 10.0
PROGRAM = [sys.executable, "-m", "aerial_gnss_ros.cli"]
SIM_TIME = ["-p", "use_sim_time:=true"]


def ip(*words: str) -> str:
    """Run ip; return what it prints."""
    command = [IP, *words]
    done = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603
    return done.stdout


@contextmanager
def networks() -> Iterator[None]:
    """Make both networks; this process's namespace is the router."""
    try:
        for side, net in SIDES.items():
            ip("netns", "add", side)
            ip("link", "add", "up0", "netns", side, "type", "veth", "peer", "name", side)
            ip("addr", "add", f"{net}.1/24", "dev", side)
            ip("link", "set", side, "up")
            ip("-n", side, "addr", "add", f"{net}.2/24", "dev", "up0")
            ip("-n", side, "link", "set", "up0", "up")
            ip("-n", side, "link", "set", "lo", "up")
            ip("-n", side, "route", "add", "default", "via", f"{net}.1")
        Path("/proc/sys/net/ipv4/ip_forward").write_text("1")
        yield
    finally:
        for side in SIDES:
            command = [IP, "netns", "del", side]
            subprocess.run(command, check=False, capture_output=True)  # noqa: S603


def started(side: str, log: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a program of this package in one of the networks."""
    other = next(net for name, net in SIDES.items() if name != side)
    environment = {
        **os.environ, "ROS_STATIC_PEERS": f"{other}.2", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
    }  # fmt: skip
    with log.open("ab") as file:
        return subprocess.Popen(  # noqa: S603
            [IP, "netns", "exec", side, *PROGRAM, *arguments],
            env=environment, stdout=file, stderr=file,
        )  # fmt: skip


def passed() -> tuple[int, int]:
    """Return the bytes from and to the drones so far."""
    found = json.loads(ip("-s", "-j", "link", "show", "drones"))[0]["stats64"]
    return int(found["rx"]["bytes"]), int(found["tx"]["bytes"])


def processor_s(process: subprocess.Popen[bytes]) -> float:
    """Return the processor time of a process so far, s."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def fly(folder: Path) -> list[str]:
    """Fly once; return the table's row."""
    two = folder / "two"
    made = ["simulate", "-o", str(two), "--drones", "2", "--no-images"]
    command = [*PROGRAM, *made, "--duration", f"{FLOWN_S:g}"]
    subprocess.run(command, check=True, capture_output=True)  # noqa: S603
    log = folder / "nodes.log"
    nodes = [
        started(
            "drones", log, "run", "--node", "estimator", "--namespace", name, "--ros-args",
            *SIM_TIME, "-p", f"sightings.drone:={name}",
        )
        for name in "ab"
    ]  # fmt: skip
    # Its clock is its own: /clock would be a load on the link that no flight has.
    fleet = started(
        "shore", log, "run", "--node", "fleet", "--namespace", "fleet", "--ros-args", "-p",
        "drones:=[/a, /b]",
    )  # fmt: skip
    try:
        time.sleep(2.5 * IDLE_S)  # all have found each other
        before, began_s = passed(), time.monotonic()
        time.sleep(IDLE_S)
        idle = [
            (b - a) / (time.monotonic() - began_s) for a, b in zip(before, passed(), strict=True)
        ]
        first, began_s = passed(), time.monotonic()
        spent = [processor_s(one) for one in (*nodes, fleet)]
        given = [part for name in "ab" for part in ("--drone", f"{name}={two / name}")]
        player = started("drones", log, "play", *given, "--wait-for", "a/estimator", "b/estimator")
        if player.wait(300):
            raise RuntimeError(log.read_text())
        lasted_s = time.monotonic() - began_s
        took = [processor_s(one) - s for one, s in zip((*nodes, fleet), spent, strict=True)]
        wire = [
            (last - b - rate * lasted_s) / 2.0 / FLOWN_S / 1e3
            for b, last, rate in zip(first, passed(), idle, strict=True)
        ]
    finally:
        for one in (*nodes, fleet):
            one.send_signal(signal.SIGINT)
        for one in (*nodes, fleet):
            one.wait(30)
    cores = [f"{100.0 * s / FLOWN_S:.0f}" for s in (sum(took[:2]) / 2.0, took[2])]
    return [*(f"{one / 1e3:.1f}" for one in idle), *(f"{one:.1f}" for one in wire), *cores]


HEADS = [
    "idle, kB/s out", "idle, kB/s back", "each drone, kB/s out", "each drone, kB/s back",
    "an estimator, % of a core", "the fleet, % of a core",
]  # fmt: skip


def main() -> int:
    """Fly and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, networks():
        row = fly(Path(folder))
    show(columns(HEADS, [row]), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
