# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Subscribes to every robot's position, including robots that appear later."""

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
from aerial_gnss_ros.nodes.names import absolute_namespace
from aerial_gnss_ros.nodes.process import work

_LOOK_S = 0.5


def hear_robots(
    namespace: str,
    seconds: float | None,
    receive: Callable[[str, Any], None],
    ros_args: Sequence[str] = (),
) -> None:
    """Receive `robots/<id>/fix` until a signal, or for a limited time.

    Args:
        namespace: of the estimator.
        seconds: duration, s; None until a signal.
        receive: called with a robot's id and the message; the last known position comes at once.
        ros_args: for ROS, such as remappings.

    Raises:
        RosError: ROS cannot start.
    """

    def task() -> None:
        with valid_names():
            node = rclpy.create_node("stream", namespace=absolute_namespace(namespace) or None)
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
                _look(node, known, receive)
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown()
        node.destroy_node()

    work(task, ["aerial-gnss", "--ros-args", *ros_args])


def ask(
    robot: str, namespace: str, seconds: float, wanted: Callable[[Any], bool]
) -> tuple[Any | None, float, list[str]]:
    """Return what is published of one robot, once.

    Args:
        robot: its label.
        namespace: of the estimator.
        seconds: wait at most so long.
        wanted: whether a message answers the question; the last position known comes first.

    Returns:
        The message, or None; the time from the question to it, s; the robots that are published.

    Raises:
        ConfigError: the label or the namespace cannot be part of a topic.
        RosError: ROS cannot start.
    """
    answers: list[Any] = []
    spent: list[float] = []
    others: list[str] = []

    def task() -> None:
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        start = int(steady.now().nanoseconds)

        def heard(message: Any) -> None:
            if not answers and wanted(message):
                answers.append(message)
                spent.append((int(steady.now().nanoseconds) - start) * 1e-9)

        with valid_names():
            node = rclpy.create_node("where", namespace=absolute_namespace(namespace) or None)
            node.create_subscription(NavSatFix, f"robots/{robot}/fix", heard, qos.latched())
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while rclpy.ok() and not answers:
            if int(steady.now().nanoseconds) - start >= seconds * 1e9:
                break
            executor.spin_once(timeout_sec=0.05)
        others.extend(name for name, _ in _published(node) if name != robot)
        executor.shutdown()
        node.destroy_node()

    work(task, ["aerial-gnss"])
    return (answers or [None])[0], (spent or [0.0])[0], others


def _look(node: Node, known: set[str], receive: Callable[[str, Any], None]) -> None:
    for robot, topic in _published(node):
        if robot in known:
            continue
        known.add(robot)

        def heard(message: Any, robot: str = robot) -> None:
            receive(robot, message)

        node.create_subscription(NavSatFix, topic, heard, qos.latched())


def _published(node: Node) -> list[tuple[str, str]]:
    """Return the robots on the graph with their topics."""
    start = node.resolve_topic_name("robots") + "/"
    found = []
    for topic, _ in node.get_topic_names_and_types():
        robot = topic.removeprefix(start).removesuffix("/fix")
        if topic == f"{start}{robot}/fix" and "/" not in robot and node.count_publishers(topic):
            found.append((robot, topic))
    return found
