# SPDX-License-Identifier: Apache-2.0
"""Measures how many images a second pass through both live nodes; run by hand, prints JSON.

    aerial-gnss simulate -o flight --duration 20 --flight orbit --raw
    python3 benchmarks/live_rate.py flight --rate 3

The bag is played faster than recorded, so that images come faster than the nodes can take them; the
player and this program share the processor with the nodes, as a camera driver would.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from vision_msgs.msg import Detection2DArray
from visualization_msgs.msg import MarkerArray

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.nodes import qos

RAW, COMPRESSED = "/camera/image_raw", "/camera/image_raw/compressed"
READY_S = 30.0


def main() -> int:
    """Play, count and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bag", type=Path)
    parser.add_argument("--rate", type=float, default=3.0, help="of playing (default 3)")
    parser.add_argument("--model", help="instead of the shipped one")
    parser.add_argument("--image-size", type=int, help="longest side given to the network, px")
    args = parser.parse_args()
    with open_bag(args.bag) as bag:
        images = RAW if RAW in bag.topics else COMPRESSED
    given = ["use_sim_time:=true", f"image.transport:={'raw' if images == RAW else 'compressed'}"]
    given += [f"model:={args.model}"] if args.model else []
    given += [f"image_size:={args.image_size}"] if args.image_size else []
    parameters = [word for one in given for word in ("-p", one)]
    nodes = start("aerial_gnss_ros.cli", "run", "--ros-args", *parameters)
    player = start(
        "aerial_gnss_ros.nodes.player", str(args.bag), "--rate", str(args.rate),
        "--wait-for", images, "/detections", "--after", "1",
    )  # fmt: skip
    try:
        figures = listen(player, nodes.pid)
    finally:
        for process in (player, nodes):
            process.send_signal(signal.SIGINT)
        status = nodes.wait(timeout=20.0)
    print(json.dumps({"cores": os.cpu_count(), "nodes_status": status, **figures}, indent=2))
    return 0 if figures["arrays"] else 1


def start(module: str, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a module of the package; its messages go to standard error."""
    return subprocess.Popen([sys.executable, "-m", module, *arguments], stdout=sys.stderr)  # noqa: S603


def cpu_s(pid: int) -> float:
    """Return the processor time that a process has used, s (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def listen(player: subprocess.Popen[bytes], pid: int) -> dict[str, Any]:
    """Count what the nodes, in the process `pid`, publish until the player ends.

    Processor time an image tells what a loaded machine hides: how many images a second an idle one
    with as many cores could take at most.
    """
    rclpy.init()
    node = rclpy.create_node("counter")
    arrays: list[float] = []
    results: list[float] = []
    lines: dict[str, dict[str, str]] = {}

    used: list[float] = []

    def array(_message: Any) -> None:
        arrays.append(time.perf_counter())
        used.append(cpu_s(pid))

    def diagnostics(message: Any) -> None:
        for line in message.status:
            lines[line.name] = {value.key: value.value for value in line.values}

    node.create_subscription(Detection2DArray, "detections", array, qos.detections())
    node.create_subscription(
        MarkerArray, "robots/markers", lambda _: results.append(time.perf_counter()), qos.latched()
    )
    node.create_subscription(DiagnosticArray, "/diagnostics", diagnostics, qos.diagnostics())
    while player.poll() is None:
        rclpy.spin_once(node, timeout_sec=0.2)
    node.destroy_node()
    rclpy.try_shutdown()
    return {
        "arrays": len(arrays),
        "arrays_per_s": per_second(arrays),
        "cpu_s_per_array": round((used[-1] - used[0]) / max(1, len(used) - 1), 3) if used else None,
        "load_average": os.getloadavg()[0],
        "results": len(results),
        "results_per_s": per_second(results),
        "detection": lines.get("detector: detection", {}),
        "positions": lines.get("estimator: positions", {}),
    }


def per_second(times: list[float]) -> float:
    """Return events a second from the first to the last."""
    return round((len(times) - 1) / (times[-1] - times[0]), 2) if len(times) > 1 else 0.0


if __name__ == "__main__":
    sys.exit(main())
