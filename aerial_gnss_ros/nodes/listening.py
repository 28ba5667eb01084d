# SPDX-License-Identifier: Apache-2.0
"""Hears live topics for some seconds, for the commands that look at a graph."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.process import work
from aerial_gnss_ros.nodes.ros_messages import message_class

_TICK_S = 1.0


def listen(
    subscriptions: Sequence[Subscription],
    namespace: str,
    seconds: float,
    take: Callable[[Subscription, Any, int], None],
    tick: Callable[[int], None],
    ros_args: Sequence[str] = (),
) -> dict[str, str]:
    """Subscribe and spin; returns earlier when a signal comes.

    Args:
        subscriptions: what to hear.
        namespace: of relative topics.
        seconds: for how long.
        take: called with the subscription, the message and the node's time, ns.
        tick: called once a second, and at the end, with the node's time, ns.
        ros_args: for ROS, such as remappings.

    Returns:
        Sentences by input about topics on which nobody publishes, or with another type.

    Raises:
        RosError: ROS cannot start, or a message type is not installed.
    """
    problems: dict[str, str] = {}

    def task() -> None:
        node = rclpy.create_node("check", namespace=namespace or None)
        for subscription in subscriptions:
            _subscribe(node, subscription, take)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        start = last = int(steady.now().nanoseconds)
        while rclpy.ok() and (now := int(steady.now().nanoseconds)) - start < seconds * 1e9:
            executor.spin_once(timeout_sec=0.1)
            if now - last >= _TICK_S * 1e9:
                last = now
                problems.clear()
                problems.update(_problems(node, subscriptions))
                tick(int(node.get_clock().now().nanoseconds))
        tick(int(node.get_clock().now().nanoseconds))
        executor.shutdown()
        node.destroy_node()

    work(task, ["aerial-gnss", "--ros-args", *ros_args])
    return problems


def _subscribe(
    node: Node, subscription: Subscription, take: Callable[[Subscription, Any, int], None]
) -> None:
    def callback(message: Any) -> None:
        take(subscription, message, int(node.get_clock().now().nanoseconds))

    node.create_subscription(
        message_class(subscription.msgtype),
        subscription.topic,
        callback,
        qos.sensor(subscription.depth),
    )


def _problems(node: Node, subscriptions: Sequence[Subscription]) -> dict[str, str]:
    found = {}
    for subscription in subscriptions:
        name = node.resolve_topic_name(subscription.topic)
        types = {info.topic_type for info in node.get_publishers_info_by_topic(name)}
        if not types:
            found[subscription.name] = f"nobody publishes {name}"
        elif subscription.msgtype not in types:
            other = ", ".join(sorted(types))
            found[subscription.name] = f"{name} carries {other}, not {subscription.msgtype}"
    return found
