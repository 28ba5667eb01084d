# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Latched topics whose messages are built only if there is a subscriber."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.publisher import Publisher

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.adapters.results import OutgoingMessage, markers
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.nodes.ros_messages import message

LOOK_S = 0.1
"""Longest wait of a subscriber that joins between images or after the last one."""


class Picture:
    """Publisher of `robots/markers`, the most expensive message; most flights have no viewer.

    Args:
        publisher: of the markers.
        frames: names of frames.
    """

    def __init__(self, publisher: Publisher, frames: Frames) -> None:
        self._publisher = publisher
        self._frames = frames
        self._newest: FrameResult | None = None

    def show(self, result: FrameResult) -> None:
        """Publish a result now, or as soon as there is a subscriber."""
        self._newest = result
        self.look()

    def look(self) -> None:
        """Publish a pending result if there is a subscriber now; call it periodically."""
        if self._newest is None or not self._publisher.get_subscription_count():
            return
        outgoing: OutgoingMessage = markers(self._newest, self._frames)
        self._newest = None
        self._publisher.publish(message(outgoing.msgtype, outgoing.fields))


class OverviewTopic:
    """Publisher of `overview`, for `aerial-gnss view`; most flights have no viewer.

    Args:
        publisher: of the topic.
        text: makes the JSON text of a result.
    """

    def __init__(self, publisher: Publisher, text: Callable[[FrameResult], str]) -> None:
        self._publisher, self._text = publisher, text
        self._newest: FrameResult | None = None

    def show(self, result: FrameResult) -> None:
        """Keep a result for `look`: faster than that nobody sees."""
        self._newest = result

    def look(self) -> None:
        """Publish the newest result if there is a subscriber; call it every `LOOK_S`."""
        if self._newest is None or not self._publisher.get_subscription_count():
            return
        result, self._newest = self._newest, None
        self._publisher.publish(message(OVERVIEW[1], {"data": self._text(result)}))
