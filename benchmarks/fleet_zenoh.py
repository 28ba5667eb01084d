# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two live drones and the fleet that hear each other through Zenoh alone.

pip install eclipse-zenoh
python benchmarks/fleet_zenoh.py --markdown docs/results/fleet.md

Estimators and player are in one DDS domain, the fleet is in the next one. A relay in each is all
that connects them: the shore's is a Zenoh router, the drones' its client, over TCP on this machine,
with the ways of config/zenoh. They carry the three topics of a fleet as they are serialized. The
drones' relay drops a share of the sightings. It stands in for zenoh-bridge-ros2dds, which does the
same and cannot be had from pip.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from functools import partial
from pathlib import Path
from typing import Any

from tables import columns, show

FLOWN_S, SETTLE_S, DRONES = 20.0, 15.0, "ab"
PORT = 17447
PROGRAM = [sys.executable, "-m", "aerial_gnss_ros.cli"]
SIM_TIME = ["-p", "use_sim_time:=true"]


def configured(ashore: bool) -> Any:
    """Return Zenoh's configuration of a side."""
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"router"' if ashore else '"client"')
    way = f'["tcp/127.0.0.1:{PORT}"]'
    config.insert_json5("listen/endpoints" if ashore else "connect/endpoints", way)
    config.insert_json5("connect/timeout_ms", "-1")  # the router may come later
    config.insert_json5("scouting/multicast/enabled", "false")
    return config


def relay(side: str, dropped: float, result: Path) -> None:
    """Carry the topics of a fleet between this DDS domain and Zenoh until a signal."""
    import rclpy
    import zenoh
    from rclpy.signals import SignalHandlerOptions
    from std_msgs.msg import String

    from aerial_gnss_ros.adapters.fleet_messages import PARAMETERS, REQUEST
    from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS
    from aerial_gnss_ros.nodes import qos

    ashore = side == "shore"
    session = zenoh.open(configured(ashore))
    stop = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stop.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(f"relay_{side}")
    passed, latched = {"messages": 0, "bytes": 0}, dict[str, bytes]()
    chance = random.Random(1)  # noqa: S311 - no secret

    def put(key: str, keep: bool, data: bytes) -> None:
        if keep:
            latched[key] = data
        elif key.endswith(SIGHTINGS[0]) and chance.random() < dropped:
            return
        passed["messages"] += 1
        passed["bytes"] += len(data)
        session.put(key, data)

    def again() -> None:  # Zenoh has no latched topics: who comes late hears it soon
        for key, data in latched.items():
            session.put(key, data)

    def publish(publisher: Any, sample: Any) -> None:
        publisher.publish(sample.payload.to_bytes())

    held: list[Any] = []
    for drone in DRONES:
        for (name, _), profile, of_drone in (
            (SIGHTINGS, qos.sightings(), True),
            (PARAMETERS, qos.latched(), True),
            (REQUEST, qos.sent_once(), False),
        ):
            key = f"{drone}/{name}"
            if of_drone != ashore:
                take = partial(put, key, name == PARAMETERS[0])
                held.append(node.create_subscription(String, f"/{key}", take, profile, raw=True))
            else:
                publisher = node.create_publisher(String, f"/{key}", profile)
                held.append(session.declare_subscriber(key, partial(publish, publisher)))
    if ashore:

        def said(message: String) -> None:
            result.write_text(message.data, encoding="utf-8")

        held.append(node.create_subscription(String, "/fleet/drones", said, qos.latched()))
    node.create_timer(2.0, again)
    while not stop.is_set():
        rclpy.spin_once(node, timeout_sec=0.2)
    if not ashore:
        result.write_text(json.dumps(passed), encoding="utf-8")
    session.close()


def fly(folder: Path, dropped: float) -> list[str]:
    """Fly once; return the table's row."""
    two = folder / "two"
    made = ["simulate", "-o", str(two), "--drones", str(len(DRONES)), "--no-images"]
    command = [*PROGRAM, *made, "--duration", f"{FLOWN_S:g}"]
    subprocess.run(command, check=True, capture_output=True)  # noqa: S603
    domain = int(os.environ.get("ROS_DOMAIN_ID", "40"))
    log = folder / "nodes.log"

    def started(side: str, *command: str) -> subprocess.Popen[bytes]:
        own = {
            **os.environ, "ROS_DOMAIN_ID": str(domain + (side == "shore")),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }  # fmt: skip
        with log.open("ab") as file:
            return subprocess.Popen([*command], env=own, stdout=file, stderr=file)  # noqa: S603

    ends = {side: folder / f"{side}.json" for side in ("shore", "drones")}
    this = [sys.executable, str(Path(__file__).resolve())]
    running = [
        started(side, *this, "--relay", side, "--dropped", f"{dropped:g}", "--end", str(end))
        for side, end in ends.items()
    ]
    fleet = ["run", "--node", "fleet", "--namespace", "fleet", "--ros-args"]
    running.append(started("shore", *PROGRAM, *fleet, "-p", "drones:=[/a, /b]"))
    for name in DRONES:
        own = ["run", "--node", "estimator", "--namespace", name, "--ros-args", *SIM_TIME]
        running.append(started("drones", *PROGRAM, *own, "-p", f"sightings.drone:={name}"))
    try:
        time.sleep(SETTLE_S)
        given = [part for name in DRONES for part in ("--drone", f"{name}={two / name}")]
        play = ["play", *given, "--wait-for", *(f"{name}/estimator" for name in DRONES)]
        if started("drones", *PROGRAM, *play).wait(300):
            raise RuntimeError(log.read_text())
        time.sleep(SETTLE_S)
    finally:
        for one in running:
            one.send_signal(signal.SIGINT)
        for one in running:
            one.wait(30)
    passed = json.loads(ends["drones"].read_text(encoding="utf-8"))
    drones = json.loads(ends["shore"].read_text(encoding="utf-8"))["drones"]
    shared = [one["shared_robots"] for one in drones]
    return [
        f"{100.0 * dropped:.0f} %", str(passed["messages"]),
        f"{passed['bytes'] / len(DRONES) / FLOWN_S / 1e3:.1f}",
        str(sum(one["missing"] for one in drones)),
        str(sum(one["lost"] for one in drones)), str(min(shared)),
    ]  # fmt: skip


HEADS = [
    "dropped", "messages ashore", "each drone, kB/s", "still missing", "lost", "robots shared",
]  # fmt: skip


def main() -> int:
    """Fly and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    parser.add_argument("--relay", help=argparse.SUPPRESS)
    parser.add_argument("--dropped", type=float, default=0.0, help=argparse.SUPPRESS)
    parser.add_argument("--end", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.relay:
        relay(given.relay, given.dropped, given.end)
        return 0
    rows = []
    for dropped in (0.0, 0.3):
        with tempfile.TemporaryDirectory() as folder:
            rows.append(fly(Path(folder), dropped))
    show(columns(HEADS, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
