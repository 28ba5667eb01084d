# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Subscribes to live topics for a limited time, for commands that inspect a graph."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import NameValidationException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.adapters.matching import SeenTopic
from aerial_gnss_ros.adapters.versions import newest_version
from aerial_gnss_ros.core.values.errors import ConfigError, RosError
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.latched import LatchedToo
from aerial_gnss_ros.nodes.names import absolute_namespace
from aerial_gnss_ros.nodes.process import work
from aerial_gnss_ros.nodes.ros_messages import message_class

_TICK_S = 1.0
_OWN = ("/rosout", "/parameter_events")


def listen(
    subscriptions: Sequence[Subscription],
    namespace: str,
    seconds: float,
    take: Callable[[Subscription, Any, int], None],
    tick: Callable[[int], None],
    ros_args: Sequence[str] = (),
) -> dict[str, str]:
    """Subscribe and spin for some time, or until a signal.

    Args:
        subscriptions: topics to subscribe to.
        namespace: of relative topics.
        seconds: duration, s.
        take: called with the subscription, the message and the node's time, ns.
        tick: called once a second, and at the end, with the node's time, ns.
        ros_args: for ROS, such as remappings.

    Returns:
        Sentences by input about topics without a publisher, or with another type.

    Raises:
        RosError: ROS cannot start, or a message type is not installed.
    """
    problems: dict[str, str] = {}

    def task() -> None:
        with valid_names():
            node = rclpy.create_node("check", namespace=absolute_namespace(namespace) or None)
            names = {s.name: node.resolve_topic_name(s.topic) for s in subscriptions}
            latched = LatchedToo(node)
            for subscription in subscriptions:
                _subscribe(node, subscription, names[subscription.name], take, latched)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        start = last = int(steady.now().nanoseconds)
        while rclpy.ok() and (now := int(steady.now().nanoseconds)) - start < seconds * 1e9:
            executor.spin_once(timeout_sec=0.1)
            if now - last >= _TICK_S * 1e9:
                last = now
                latched.look()
                for subscription in subscriptions:
                    version = _newest_version(node, subscription, names[subscription.name])
                    if version != names[subscription.name]:
                        names[subscription.name] = version
                        _subscribe(node, subscription, version, take, latched)
                problems.clear()
                problems.update(_problems(node, subscriptions, names))
                tick(int(node.get_clock().now().nanoseconds))
        tick(int(node.get_clock().now().nanoseconds))
        executor.shutdown()
        node.destroy_node()

    work(task, ["aerial-gnss", "--ros-args", *ros_args])
    return problems


@contextmanager
def valid_names() -> Iterator[None]:
    """Convert rclpy's multi-line report of an invalid name into a sentence.

    Raises:
        ConfigError: a namespace or topic is invalid.
    """
    try:
        yield
    except NameValidationException as error:
        reason = str(error).split("\n", 1)[0].split(": ", 1)[-1].rstrip(":. ")
        raise ConfigError(f"a namespace or topic is invalid: {reason}.") from error


def _subscribe(
    node: Node,
    subscription: Subscription,
    topic: str,
    take: Callable[[Subscription, Any, int], None],
    latched: LatchedToo,
) -> None:
    def callback(message: Any) -> None:
        take(subscription, message, int(node.get_clock().now().nanoseconds))

    kind, depth = message_class(subscription.msgtype), subscription.depth
    heard: Callable[..., None] = callback
    if subscription.sent_once:
        heard = latched.watch(subscription.name, topic, kind, depth, callback)
    node.create_subscription(kind, topic, heard, qos.sensor(depth))


def _newest_version(node: Node, subscription: Subscription, current: str) -> str:
    """Return the topic to subscribe to: PX4 appends _v1 and so on when a message changes."""
    if not subscription.versioned:
        return current
    names = [name for name, _ in node.get_topic_names_and_types()]
    return newest_version(current, [name for name in names if node.count_publishers(name)])


def _problems(
    node: Node, subscriptions: Sequence[Subscription], names: Mapping[str, str]
) -> dict[str, str]:
    found = {}
    for subscription in subscriptions:
        name = names[subscription.name]
        types = {info.topic_type for info in node.get_publishers_info_by_topic(name)}
        if not types:
            found[subscription.name] = f"nobody publishes {name}"
        elif subscription.msgtype not in types:
            other = ", ".join(sorted(types))
            found[subscription.name] = f"{name} carries {other}, not {subscription.msgtype}"
    return found


def survey(seconds: float, ros_args: Sequence[str] = ()) -> list[SeenTopic]:
    """Return the live topics with their types, and rates of those whose type is installed.

    Args:
        seconds: duration, s.
        ros_args: for ROS.

    Raises:
        RosError: ROS cannot start.
    """
    counts: dict[str, int] = {}
    types: dict[str, str] = {}
    troubles: dict[str, str] = {}

    def task() -> None:
        node = rclpy.create_node("doctor")
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        start = int(steady.now().nanoseconds)
        while rclpy.ok() and int(steady.now().nanoseconds) - start < seconds * 1e9:
            _discover(node, types, troubles, counts)
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown()
        node.destroy_node()

    work(task, ["aerial-gnss", "--ros-args", *ros_args])
    return [
        SeenTopic(name, types[name], counts[name] / seconds, counts[name], troubles.get(name, ""))
        for name in sorted(types)
    ]


def _discover(
    node: Node, types: dict[str, str], troubles: dict[str, str], counts: dict[str, int]
) -> None:
    for name, found in node.get_topic_names_and_types():
        if name in types or not node.count_publishers(name) or name in _OWN:
            continue
        types[name], counts[name] = " and ".join(sorted(found)), 0
        try:
            kind = message_class(found[0])
        except RosError as error:
            troubles[name] = str(error)
            continue

        def count(_raw: bytes, name: str = name) -> None:
            counts[name] += 1

        node.create_subscription(kind, name, count, qos.sensor(10), raw=True)
