# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plays a bag into ROS in real time: images best effort, detections reliable, /clock with it.

Recorded bytes are published unchanged. The messages carry the time of the recording, so subscribing
nodes need `use_sim_time`; /clock gives them the bag's time.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import QosDurability, QosReliability
from rosgraph_msgs.msg import Clock

from aerial_gnss_ros.adapters.stamps import stamp_fields
from aerial_gnss_ros.bags.reader import BagReader, Recorded, Topic, open_bag
from aerial_gnss_ros.core.values.errors import AerialGnssError, InputError, RosError
from aerial_gnss_ros.nodes import process, qos
from aerial_gnss_ros.nodes.fleet_bag import FleetBag
from aerial_gnss_ros.nodes.played_topics import DETECTIONS, IMAGES, moved
from aerial_gnss_ros.nodes.ros_messages import message, message_class
from aerial_gnss_ros.nodes.transport import use_large_data_profile

_IMAGE_DEPTH = 5
_TELEMETRY_DEPTH = 50
_CLOCK_STEP_S = 0.01
_PAUSE_S = 0.05
_SETTLE_S = 0.5  # discovery is asymmetric: a subscriber may match later than its publisher
_LINGER_S = 0.5  # a large message stays in this process's memory until it has been read


class Player:
    """Publishes a bag's messages when they are due.

    Args:
        node: owns the publishers.
        bag: open.
        topics: absolute names to play; None for all that are installed here.
        rate: 2.0 plays twice as fast.
        namespace: below which topics are played.
        installed_only: leave out topics whose message type is not installed; so does None.

    Attributes:
        published: messages published so far by topic, as recorded.
        paused: while True, /clock stands still and nothing else is published.

    Raises:
        InputError: the bag has none of the topics, or is a ROS 1 bag.
    """

    def __init__(
        self,
        node: Node,
        bag: BagReader | FleetBag,
        topics: Collection[str] | None = None,
        rate: float = 1.0,
        *,
        namespace: str = "",
        installed_only: bool = False,
    ) -> None:
        self._node = node
        self._namespace = namespace
        self._start = 0.0
        self.paused = False
        self._bag = bag
        self._rate = rate
        self._publishers: dict[str, Publisher] = {}
        if any(path.suffix == ".bag" for path in bag.paths):
            raise InputError(f"{bag.paths[0]} is a ROS 1 bag; it can be replayed, but not played.")
        for topic in bag.topics.values():
            if topics is None or topic.name in topics:
                self._announce(node, topic, known_only=installed_only or topics is None)
        if not self._publishers:
            raise InputError(
                f"nothing to play: {', '.join(map(str, bag.paths))} has "
                f"{', '.join(bag.topics) or 'no topics'}."
            )
        self.published = dict.fromkeys(self._publishers, 0)
        clock = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._clock = node.create_publisher(Clock, "/clock", clock)

    def _announce(self, node: Node, topic: Topic, *, known_only: bool) -> None:
        try:
            kind = message_class(topic.msgtype)
        except RosError:
            if not known_only:
                raise
            node.get_logger().warning(f"{topic.name} is not played: no type {topic.msgtype} here")
            return
        name = moved(topic.name, self._namespace)
        self._publishers[topic.name] = node.create_publisher(kind, name, _profile(topic))

    def wait_for_subscribers(self, topics: Collection[str], timeout_s: float) -> list[str]:
        """Wait until each of `topics` has a subscriber; return those without one."""
        deadline = time.monotonic() + timeout_s
        waited = [name for name in topics if name in self._publishers]
        missing = waited
        while time.monotonic() < deadline:
            missing = [n for n in waited if not self._publishers[n].get_subscription_count()]
            if not missing:
                time.sleep(_SETTLE_S)
                break
            time.sleep(0.05)
        return missing

    def wait_for_nodes(
        self, names: Collection[str], timeout_s: float, going_on: Callable[[], bool] = rclpy.ok
    ) -> list[str]:
        """Wait until each node subscribes to a played topic; return those that do not.

        Args:
            names: of the nodes, in this node's namespace or below it, such as drone1/estimator.
            timeout_s: longest wait, s.
            going_on: ends the wait when it returns False.
        """
        deadline = time.monotonic() + timeout_s
        missing = list(names)
        while missing and going_on() and time.monotonic() < deadline:
            missing = [name for name in missing if not self._heard_by(name)]
            time.sleep(0.05 if missing else _SETTLE_S)
        return missing

    def _heard_by(self, name: str) -> bool:
        played = {publisher.topic_name for publisher in self._publishers.values()}
        below, _, own = name.strip("/").rpartition("/")
        namespace = f"{self._node.get_namespace().rstrip('/')}/{below}".rstrip("/") or "/"
        try:
            found = self._node.get_subscriber_names_and_types_by_node(own, namespace)
        except NodeNameNonExistentError:
            return False
        return any(topic in played for topic, _ in found)

    def play(self, going_on: Callable[[], bool] = rclpy.ok, from_ns: int = 0) -> int:
        """Publish until the end of the bag or until `going_on` is False; return the bag's time, ns.

        Args:
            going_on: ends playing when it returns False.
            from_ns: log time to begin at; of earlier messages, only latched ones are sent.

        Raises:
            InputError: the bag is damaged.
        """
        first_ns = now_ns = max(self._bag.start_ns, from_ns)
        self._start = time.monotonic()
        for recorded in self._bag.messages(set(self._publishers)):
            if recorded.log_ns < first_ns:
                self._send_if_latched(recorded)
                continue
            if not self._run_clock(first_ns, now_ns, recorded.log_ns, going_on):
                break
            now_ns = recorded.log_ns
            self._publishers[recorded.topic].publish(recorded.raw)
            self.published[recorded.topic] += 1
        return now_ns

    def run_on(self, from_ns: int, seconds: float, going_on: Callable[[], bool] = rclpy.ok) -> None:
        """Continue /clock after the last message, for nodes that wait for a time."""
        self._start = time.monotonic()
        self._run_clock(from_ns, from_ns, from_ns + int(seconds * 1e9), going_on)

    def _run_clock(
        self, first_ns: int, now_ns: int, due_ns: int, going_on: Callable[[], bool]
    ) -> bool:
        """Advance /clock in steps until a message is due; return whether to publish it."""
        step_ns = int(_CLOCK_STEP_S * 1e9 * self._rate)
        while going_on():
            if self.paused:
                self._hold(now_ns)
                continue
            now_ns = min(now_ns + step_ns, due_ns)
            wait_s = self._start + (now_ns - first_ns) / 1e9 / self._rate - time.monotonic()
            if wait_s > 0.0:
                time.sleep(wait_s)
            self._tell_time(now_ns)
            if now_ns >= due_ns:
                return True
        return False

    def _hold(self, now_ns: int) -> None:
        """Sleep for a moment without advancing /clock."""
        began = time.monotonic()
        self._tell_time(now_ns)
        time.sleep(_PAUSE_S)
        self._start += time.monotonic() - began

    def _tell_time(self, now_ns: int) -> None:
        fields = {"clock": stamp_fields(now_ns)}
        self._clock.publish(message("rosgraph_msgs/msg/Clock", fields))

    def _send_if_latched(self, recorded: Recorded) -> None:
        offers = self._bag.topics[recorded.topic].qos
        if offers and all(o.durability == QosDurability.TRANSIENT_LOCAL for o in offers):
            self._publishers[recorded.topic].publish(recorded.raw)


def _profile(topic: Topic) -> QoSProfile:
    if topic.msgtype in IMAGES:
        return qos.sensor(_IMAGE_DEPTH)
    if topic.msgtype == DETECTIONS:
        return qos.detections()
    profile = QoSProfile(depth=_TELEMETRY_DEPTH)
    if any(offer.reliability == QosReliability.BEST_EFFORT for offer in topic.qos):
        profile.reliability = ReliabilityPolicy.BEST_EFFORT
    if topic.qos and all(o.durability == QosDurability.TRANSIENT_LOCAL for o in topic.qos):
        profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return profile


def main(argv: Sequence[str] | None = None) -> int:
    """Play bags in a separate process: `python3 -m aerial_gnss_ros.nodes.player BAG...`."""
    arguments = list(sys.argv if argv is None else argv)
    parser = argparse.ArgumentParser(prog="player", description="Play bags into ROS.")
    parser.add_argument("bags", nargs="+", type=Path)
    parser.add_argument("--rate", type=float, default=1.0, help="2 plays twice as fast")
    parser.add_argument("--topics", nargs="+", help="absolute names; all when absent")
    parser.add_argument("--wait-for", nargs="+", default=[], help="until somebody listens to them")
    parser.add_argument("--wait", type=float, default=30.0, help="at most this many seconds")
    parser.add_argument(
        "--after", type=float, default=0.0, help="seconds /clock goes on at the end"
    )
    args = parser.parse_args(process.own_arguments(arguments)[1:])
    use_large_data_profile()
    try:
        if args.rate <= 0.0:
            raise InputError(f"--rate {args.rate} is not a speed; give a positive number.")
        with open_bag(args.bags) as bag:
            return process.work(lambda: _play(args, bag), arguments)
    except AerialGnssError as error:
        sys.stderr.write(f"player: {error}\n")
        return process.WRONG_INPUT


def _play(args: Any, bag: BagReader) -> None:
    node = rclpy.create_node("player")
    player = Player(node, bag, args.topics, args.rate)
    missing = player.wait_for_subscribers(args.wait_for, args.wait)
    if missing:
        node.get_logger().warning(f"nobody listens to {', '.join(missing)}")
    player.run_on(player.play(), args.after)
    if rclpy.ok():
        time.sleep(_LINGER_S)
    node.destroy_node()


if __name__ == "__main__":
    sys.exit(main())
