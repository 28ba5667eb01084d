# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Processor time of the live page's server: `python benchmarks/view.py`.

Publishes overviews of 20 robots and camera images at 10 Hz, and measures what `aerial-gnss view`
spends while nobody watches, while one browser does, and while it shows the image, too. In Linux.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import math
import os
import re
import subprocess
import sys
import threading
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import rclpy
import tornado.websocket
from rclpy.node import Node
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import String
from vision_msgs.msg import Detection2DArray

from aerial_gnss_ros.adapters.overview import OVERVIEW, Light, overview_text
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State
from aerial_gnss_ros.core.values.overview import Overview
from aerial_gnss_ros.nodes import qos

BEGIN_NS = 1_735_689_600_000_000_000
LIGHTS = [Light(name, "ok", "received") for name in ("fix", "gimbal", "height", "detections")]
SETTLE_S = 3.0


def flight(robots: int, rate_hz: float, seconds: float) -> list[str]:
    """Return the texts of overviews of robots on circles."""
    texts = []
    for i in range(round(rate_hz * seconds)):
        stamp_ns = BEGIN_NS + round(i / rate_hz * 1e9)
        estimates = tuple(_robot(k, i / rate_hz, stamp_ns) for k in range(robots))
        pose = CameraPose(stamp_ns, 0.2303, -1.0409, 20.0, math.nan, np.eye(3))
        result = FrameResult(stamp_ns, "camera", estimates, (), None, pose)
        corners = np.array([[0.2303, -1.0409], [0.2303, -1.04089], [0.23031, -1.0409]])
        pixels = np.full((robots, 2), 100.0)
        seen = Overview(result, np.repeat(corners, 6, axis=0), pixels, np.zeros(robots))
        texts.append(overview_text(seen, stamp_ns, (), LIGHTS))
    return texts


def _robot(number: int, seconds: float, stamp_ns: int) -> RobotEstimate:
    angle = 0.05 * seconds + number
    latitude, longitude = 0.2303 + 3e-6 * math.sin(angle), -1.0409 + 3e-6 * math.cos(angle)
    return RobotEstimate(
        stamp_ns, f"aqua_{number + 1}", "aqua", State.CONFIRMED, latitude, longitude, math.nan,
        np.zeros(2), np.zeros(2), np.eye(4), stamp_ns,
    )  # fmt: skip


def publish(texts: list[str], rate_hz: float, ended: threading.Event) -> None:
    """Publish overviews, and images as often, until told to end."""
    node = Node("publisher", enable_rosout=False)
    overviews = node.create_publisher(String, OVERVIEW[0], qos.latched())
    images = node.create_publisher(CompressedImage, "camera/image_raw/compressed", qos.sensor(1))
    boxes = node.create_publisher(Detection2DArray, "detections", qos.detections())
    noise = np.random.default_rng(1).integers(90, 120, (720, 1280, 3), dtype=np.uint8)
    content = cv2.imencode(".jpg", noise)[1].tobytes()
    for i in range(1_000_000):
        if ended.wait(1.0 / rate_hz):
            break
        overviews.publish(String(data=texts[i % len(texts)]))
        stamp = BEGIN_NS + round(i % len(texts) / rate_hz * 1e9)
        message = CompressedImage(format="jpeg", data=content)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
        images.publish(message)
        boxes.publish(Detection2DArray(header=message.header))
    node.destroy_node()


def spent_s(process: int) -> float:
    """Return the processor time that a process has used, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def watch(
    url: str, picture: bool, seconds: float, process: int
) -> tuple[float, Counter[str]]:
    """Be a browser for some time; return the server's share of a core, and what it sent."""
    connection = await tornado.websocket.websocket_connect(url, max_message_size=100_000_000)
    await connection.write_message(json.dumps({"picture": picture}))
    got: Counter[str] = Counter()

    async def read() -> None:
        while (message := await connection.read_message()) is not None:
            got["pictures" if isinstance(message, bytes) else json.loads(message)["kind"]] += 1

    reading = asyncio.ensure_future(read())
    await asyncio.sleep(SETTLE_S)
    before = spent_s(process)
    got.clear()
    await asyncio.sleep(seconds)
    share = (spent_s(process) - before) / seconds
    connection.close()
    await reading
    return share, got


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--rate", type=float, default=10.0, help="Hz (%(default)g)")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each row (%(default)g)")
    args = parser.parse_args()
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", "view", "--port", "0"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603 - our own
    assert server.stdout is not None  # noqa: S101 - a pipe, as asked
    found = re.search(r"http://\S+", server.stdout.readline())
    assert found is not None, "the server does not begin"  # noqa: S101
    url = found[0].replace("http", "ws") + "socket"
    rclpy.init(args=[])
    ended = threading.Event()
    texts = flight(args.robots, args.rate, 60.0)
    thread = threading.Thread(target=publish, args=(texts, args.rate, ended))
    thread.start()
    try:
        asyncio.run(_measure(url, server.pid, args.seconds))
    finally:
        ended.set()
        thread.join()
        server.terminate()
        server.wait()
        rclpy.shutdown()


async def _measure(url: str, process: int, seconds: float) -> None:
    await asyncio.sleep(SETTLE_S)
    before = spent_s(process)
    await asyncio.sleep(seconds)
    print(f"not watched: {100.0 * (spent_s(process) - before) / seconds:.1f} % of a core")
    for words, picture in (("watched", False), ("watched, with the image", True)):
        share, got = await watch(url, picture, seconds, process)
        rates = ", ".join(f"{count / seconds:.1f} {kind}/s" for kind, count in sorted(got.items()))
        print(f"{words}: {100.0 * share:.1f} % of a core ({rates})")


if __name__ == "__main__":
    main()
