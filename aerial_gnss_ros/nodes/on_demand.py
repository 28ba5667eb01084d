# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A latched topic whose messages are made only for somebody who listens."""

from __future__ import annotations

from rclpy.publisher import Publisher

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.results import OutgoingMessage, markers
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.nodes.ros_messages import message

LOOK_S = 0.1
"""A viewer that joins between images, or after the last one, waits at most so long."""


class Picture:
    """`robots/markers`: most flights have no viewer, and its message is the dearest of all.

    Args:
        publisher: of the topic.
        frames: names of frames.
    """

    def __init__(self, publisher: Publisher, frames: Frames) -> None:
        self._publisher = publisher
        self._frames = frames
        self._newest: FrameResult | None = None

    def show(self, result: FrameResult) -> None:
        """Publish a result, now or when somebody listens."""
        self._newest = result
        self.look()

    def look(self) -> None:
        """Publish what nobody heard yet, if somebody listens now; call it now and then."""
        if self._newest is None or not self._publisher.get_subscription_count():
            return
        outgoing: OutgoingMessage = markers(self._newest, self._frames)
        self._newest = None
        self._publisher.publish(message(outgoing.msgtype, outgoing.fields))
