# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fetches overviews, diagnostics and images for the live page, and subscribes only meanwhile.

Nothing is called back: the page asks a few times a second for the newest message. So a camera's 30
images a second cost no more than the few that are shown, and an unwatched page costs nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from aerial_gnss_ros.adapters.overview import ERROR, OK, OVERVIEW, WARNING, Light
from aerial_gnss_ros.core.values.errors import RosError
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.listening import valid_names
from aerial_gnss_ros.nodes.names import absolute_namespace
from aerial_gnss_ros.nodes.ros_messages import message_class
from aerial_gnss_ros.text.plain_text import printable

_LEVELS = {b"\x00": OK, b"\x01": WARNING, b"\x02": ERROR, b"\x03": ERROR}
"""Diagnostic levels; an input that never sent (STALE) is as bad as a wrong one."""
_ROBOT = "robot "
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
DETECTIONS = "vision_msgs/msg/Detection2DArray"


class OverviewListener:
    """A node that fetches what the page shows.

    Args:
        namespace: of the estimator.
        image: topic of raw images; compressed ones below it are preferred.
        detections: topic of the boxes.
        ros_args: for ROS, such as remappings.

    Raises:
        ConfigError: the namespace cannot be part of a topic.
        RosError: ROS cannot start.
    """

    def __init__(
        self, namespace: str, image: str, detections: str, ros_args: Sequence[str] = ()
    ) -> None:
        try:
            # The web server ends on signals by itself.
            rclpy.init(
                args=["aerial-gnss", "--ros-args", *ros_args],
                signal_handler_options=SignalHandlerOptions.NO,
            )
        except Exception as error:
            raise RosError(f"ROS cannot start: {' '.join(str(error).split())}.") from error
        try:
            with valid_names():
                self._node: Node = rclpy.create_node(
                    "view",
                    namespace=absolute_namespace(namespace) or None,
                    enable_rosout=False,
                    start_parameter_services=False,
                )
        except Exception:
            rclpy.try_shutdown()
            raise
        self._image, self._detections = image, detections
        self._subscribed: dict[str, Subscription] = {}

    def watch(self) -> None:
        """Subscribe to overviews and diagnostics; the estimator makes overviews from now on."""
        self._subscribe("overview", *OVERVIEW, qos.latched())
        self._subscribe(
            "diagnostics", "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", qos.diagnostics()
        )

    def look(self) -> None:
        """Subscribe to images and boxes."""
        compressed = self._node.count_publishers(f"{self._image}/compressed") > 0
        self._subscribe_to_images(compressed)
        self._subscribe("detections", self._detections, DETECTIONS, qos.detections())

    def _subscribe_to_images(self, compressed: bool) -> None:
        name, kind = (
            (f"{self._image}/compressed", COMPRESSED) if compressed else (self._image, IMAGE)
        )
        self._subscribe("image", name, kind, qos.sensor(1))

    def rest(self, *names: str) -> None:
        """End subscriptions: overview, diagnostics, image, detections; without names all."""
        for name in names or tuple(self._subscribed):
            subscription = self._subscribed.pop(name, None)
            if subscription is not None:
                self._node.destroy_subscription(subscription)

    def overview(self) -> str | None:
        """Return the newest overview that has not been fetched yet."""
        message = self._newest("overview")
        return None if message is None else str(message.data)

    def image(self) -> Any:
        """Return the newest image that has not been fetched yet, or None."""
        subscription = self._subscribed.get("image")
        message = self._newest("image")
        if message is None and subscription is not None:
            compressed = subscription.topic_name.endswith("/compressed")
            others = self._image if compressed else f"{self._image}/compressed"
            count = self._node.count_publishers
            if not count(subscription.topic_name) and count(others):  # they began later
                self.rest("image")
                self._subscribe_to_images(not compressed)
        return message

    def detections(self) -> Iterator[Any]:
        """Yield the arrays of boxes that have not been fetched yet."""
        while (message := self._take("detections")) is not None:
            yield message

    def lights(self) -> Iterator[Light]:
        """Yield the lines of this drone's nodes, or the fleet's, in the diagnostics not fetched."""
        prefix = self._node.get_namespace().strip("/")
        names = {
            f"{prefix}/{name}".lstrip("/"): f"{name} " if name == "detector" else ""
            for name in ("estimator", "detector", "fleet")
        }
        while (message := self._take("diagnostics")) is not None:
            yield from lights_of(message, names)

    def close(self) -> None:
        """Leave ROS."""
        self.rest()
        self._node.destroy_node()
        rclpy.try_shutdown()

    def _subscribe(self, name: str, topic: str, kind: str, profile: QoSProfile) -> None:
        if name not in self._subscribed:
            self._subscribed[name] = self._node.create_subscription(
                message_class(kind), topic, lambda _message: None, profile
            )

    def _newest(self, name: str) -> Any:
        """Return the last message that waits, or None."""
        newest = None
        while (message := self._take(name)) is not None:
            newest = message
        return newest

    def _take(self, name: str) -> Any:
        """Return the next message that waits, or None; what an executor does, without waiting."""
        subscription = self._subscribed.get(name)
        if subscription is None:
            return None
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, False)
        return None if taken is None else taken[0]


def lights_of(array: DiagnosticArray, nodes: dict[str, str]) -> Iterator[Light]:
    """Yield the lights in diagnostics, but those of robots, which the page lists.

    Args:
        array: of one node or several.
        nodes: what precedes a light's name, by full name of its node; others are left out.
    """
    for status in array.status:
        node, _, name = status.name.partition(": ")
        if node in nodes and not name.startswith(_ROBOT):
            level = _LEVELS.get(status.level, ERROR)
            yield Light(nodes[node] + printable(name), level, printable(status.message))
