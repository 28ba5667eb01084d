# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Disturbs telemetry and detections briefly, as a drone's power supply or radio would."""

from __future__ import annotations

import math
import random
import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message

from aerial_gnss_ros.adapters.stamps import nanoseconds, stamp_fields
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.ros_messages import message, message_class

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
TELEMETRY = ("fix", "attitude", "gimbal", "height")
SECOND_NS = 1_000_000_000
DAY_NS = 86_400 * SECOND_NS
SECONDS = {
    "fix is NaN": 1.0,
    "fix is 0, 0": 1.0,
    "one stamp a day ahead": 0.1,
    "telemetry silent": 2.0,
    "height jumps by 5 m": 1.0,
    "boxes are noise": 1.0,
}
"""Kinds of disturbances and their durations, s."""

STEPS = {"clock steps an hour ahead": 3600 * SECOND_NS, "clock steps back": -3600 * SECOND_NS}
"""Permanent steps of the clock that stamps all messages, ns."""

_BOXES = 12


class Disturber:
    """Modifies messages before they are published.

    Args:
        node: publishes false detections.
        types: message types of the topics that are played, by absolute name.
        images: the topic of the images.

    Attributes:
        stepped_ns: total step of the clock that stamps all messages, ns.
    """

    def __init__(self, node: Node, types: dict[str, str], images: str) -> None:
        self._node, self._types, self._images = node, types, images
        self._kind, self._until_s = "", 0.0
        self.stepped_ns = 0
        self._chance = random.Random(1)  # noqa: S311 - noise, no secret
        self._false: Any = None

    def listen(self, lines: Iterable[str]) -> None:
        """Read kinds, one per line, in a separate thread."""

        def read() -> None:
            for line in lines:
                self.begin(line.strip())

        threading.Thread(target=read, daemon=True).start()

    def begin(self, kind: str) -> None:
        """Start a disturbance; it ends by itself, except a step of the clock."""
        if kind in STEPS:
            self.stepped_ns += STEPS[kind]
            return
        self._until_s = time.monotonic() + SECONDS[kind]
        self._kind = kind

    def altered(self, topic: str, raw: bytes) -> bytes | None:
        """Return the message to publish; None to drop it."""
        if time.monotonic() >= self._until_s:
            self._silence()
            return raw
        name = topic.rsplit("/", 1)[-1]
        if self._kind == "telemetry silent" and topic.lstrip("/") in TELEMETRY:
            return None
        if self._kind == "boxes are noise" and topic == self._images:
            self._noise(raw)
        change = self._change(name) if topic.count("/") == 1 else None
        if change is None:
            return raw
        decoded = deserialize_message(raw, message_class(self._types[topic]))
        change(decoded)
        return bytes(serialize_message(decoded))

    def _change(self, name: str) -> Callable[[Any], None] | None:
        changes: dict[tuple[str, str], Callable[[Any], None]] = {
            ("fix is NaN", "fix"): lambda fix: _place(fix, math.nan),
            ("fix is 0, 0", "fix"): lambda fix: _place(fix, 0.0),
            ("height jumps by 5 m", "height"): _higher,
            ("one stamp a day ahead", "fix"): self._ahead,
        }
        return changes.get((self._kind, name))

    def _ahead(self, fix: Any) -> None:
        self._until_s = 0.0  # one is enough
        later = stamp_fields(nanoseconds(fix.header.stamp) + DAY_NS)
        fix.header.stamp.sec, fix.header.stamp.nanosec = later["sec"], later["nanosec"]

    def _noise(self, raw: bytes) -> None:
        """Publish false boxes with an image's stamp."""
        if self._false is None:
            kind = message_class(DETECTIONS_TYPE)
            self._false = self._node.create_publisher(kind, "detections", qos.detections())
        image = deserialize_message(raw, message_class(self._types[self._images]))
        stamp = stamp_fields(nanoseconds(image.header.stamp))
        found = [
            {
                "results": [{"hypothesis": {"class_id": "aqua", "score": 0.9}}],
                "bbox": {
                    "center": {
                        "position": {
                            "x": self._chance.uniform(0.0, image.width),
                            "y": self._chance.uniform(0.0, image.height),
                        }
                    },
                    "size_x": self._chance.choice((10.0, 1e9, math.nan, -5.0)),
                    "size_y": 10.0,
                },
            }
            for _ in range(_BOXES)
        ]
        header = {"stamp": stamp, "frame_id": image.header.frame_id}
        self._false.publish(message(DETECTIONS_TYPE, {"header": header, "detections": found}))

    def _silence(self) -> None:
        """Destroy the publisher of false boxes: the node reports a second publisher."""
        if self._false is not None:
            self._node.destroy_publisher(self._false)
            self._false = None


def _place(fix: Any, degrees: float) -> None:
    fix.latitude = fix.longitude = degrees


def _higher(height: Any) -> None:
    height.data += 5.0
