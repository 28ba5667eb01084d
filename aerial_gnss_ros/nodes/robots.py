# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hears every robot's published position, also of robots that appear later."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import NavSatFix

from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.listening import valid_names
from aerial_gnss_ros.nodes.process import work

_LOOK_S = 0.5


def hear_robots(
    namespace: str,
    seconds: float | None,
    take: Callable[[str, Any], None],
    ros_args: Sequence[str] = (),
) -> None:
    """Hear `robots/<id>/fix` until a signal comes, or for some seconds.

    Args:
        namespace: of the estimator.
        seconds: for how long; None: until a signal.
        take: called with a robot's id and the message; the last position known comes at once.
        ros_args: for ROS, such as remappings.

    Raises:
        RosError: ROS cannot start.
    """

    def task() -> None:
        with valid_names():
            node = rclpy.create_node("stream", namespace=namespace or None)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        known: set[str] = set()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        start, looked = int(steady.now().nanoseconds), 0
        while rclpy.ok():
            now = int(steady.now().nanoseconds)
            if seconds is not None and now - start >= seconds * 1e9:
                break
            if now - looked >= _LOOK_S * 1e9:
                looked = now
                _look(node, known, take)
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown()
        node.destroy_node()

    work(task, ["aerial-gnss", "--ros-args", *ros_args])


def _look(node: Node, known: set[str], take: Callable[[str, Any], None]) -> None:
    start = node.resolve_topic_name("robots") + "/"
    for topic, _ in node.get_topic_names_and_types():
        robot = topic.removeprefix(start).removesuffix("/fix")
        if topic != f"{start}{robot}/fix" or robot in known or "/" in robot:
            continue
        known.add(robot)

        def heard(message: Any, robot: str = robot) -> None:
            take(robot, message)

        node.create_subscription(NavSatFix, topic, heard, qos.latched())
