# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plays a short recording into ROS endlessly with current stamps: a simulated camera and drone.

python3 -m aerial_gnss_ros.benchmarking.camera BAG --images /camera/image_raw --topics ...
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher

from aerial_gnss_ros.adapters.stamps import stamp_fields
from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.benchmarking.disturbing import Disturber
from aerial_gnss_ros.benchmarking.loop import Loop
from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.nodes import process, qos
from aerial_gnss_ros.nodes.ros_messages import message, message_class
from aerial_gnss_ros.nodes.transport import use_large_data_profile

_IMAGE_DEPTH, _TELEMETRY_DEPTH = 5, 50
_CLOCK = "rosgraph_msgs/msg/Clock"
_MEET_S = 1.0
"""Time for publishers and subscribers to find each other before the first message."""


def main(argv: Sequence[str] | None = None) -> int:
    """Play until a signal; return the exit status."""
    arguments = list(sys.argv if argv is None else argv)
    parser = argparse.ArgumentParser(prog="camera", description=__doc__)
    parser.add_argument("bag", type=Path)
    parser.add_argument("--images", required=True, help="topic of the images")
    parser.add_argument("--topics", nargs="+", required=True, help="all topics to play")
    parser.add_argument("--rate", type=float, default=1.0, help="2 plays twice as fast")
    parser.add_argument(
        "--disturb", action="store_true", help="read kinds of disturbances from standard input"
    )
    parser.add_argument(
        "--clock", action="store_true", help="publish /clock, for nodes with use_sim_time"
    )
    args = parser.parse_args(process.own_arguments(arguments)[1:])
    use_large_data_profile()
    try:
        with open_bag([args.bag]) as bag:
            loop = Loop(bag, args.topics, args.images)
            return process.work(lambda: _play(bag, loop, args), arguments)
    except AerialGnssError as error:
        sys.stderr.write(f"camera: {error}\n")
        return process.WRONG_INPUT


def _play(bag: BagReader, loop: Loop, args: argparse.Namespace) -> None:
    node = rclpy.create_node("camera")
    publishers = {name: _publisher(node, bag, name, args.images) for name in args.topics}
    kind = message_class(_CLOCK)
    clock = node.create_publisher(kind, "/clock", qos.sensor(1)) if args.clock else None
    disturber = None
    if args.disturb:
        types = {name: bag.topics[name].msgtype for name in args.topics}
        disturber = Disturber(node, types, args.images)
        disturber.listen(sys.stdin)
    time.sleep(_MEET_S)
    began, began_ns = time.monotonic(), int(node.get_clock().now().nanoseconds)
    for moment in loop.moments():
        wait_s = began + moment.due_ns * 1e-9 / args.rate - time.monotonic()
        if wait_s > 0.0:
            time.sleep(wait_s)
        if not rclpy.ok():
            break
        entry = moment.entry
        stamp_ns = began_ns + round(moment.stamp_ns / args.rate)
        if disturber is not None:
            stamp_ns += disturber.stepped_ns
        if clock is not None:
            clock.publish(message(_CLOCK, {"clock": stamp_fields(stamp_ns)}))
        raw: bytes | None = entry.raw(stamp_ns)
        if disturber is not None and raw is not None:
            raw = disturber.altered(entry.topic, raw)
        if raw is not None:
            publishers[entry.topic].publish(raw)
    node.destroy_node()


def _publisher(node: Node, bag: BagReader, topic: str, images: str) -> Publisher:
    depth = _IMAGE_DEPTH if topic == images else _TELEMETRY_DEPTH
    return node.create_publisher(message_class(bag.topics[topic].msgtype), topic, qos.sensor(depth))


if __name__ == "__main__":
    sys.exit(main())
