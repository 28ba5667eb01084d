# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Latched topics whose messages are built only if there is a subscriber."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.publisher import Publisher

from aerial_gnss_ros.core.values.estimates import FrameResult

LOOK_S = 0.1
"""Longest wait of a subscriber that joins between images or after the last one."""


class OnDemandTopic:
    """Publisher of messages made of results; most flights have no viewer.

    Args:
        publisher: of the topic.
        make: makes the message of a result.
    """

    def __init__(self, publisher: Publisher, make: Callable[[FrameResult], Any]) -> None:
        self._publisher, self._make = publisher, make
        self._newest: FrameResult | None = None

    def keep(self, result: FrameResult) -> None:
        """Keep a result for `look`."""
        self._newest = result

    def show(self, result: FrameResult) -> None:
        """Publish a result now, or as soon as there is a subscriber."""
        self.keep(result)
        self.look()

    def look(self) -> None:
        """Publish the newest result, once, if there is a subscriber; call it every `LOOK_S`."""
        if self._newest is None or not self._publisher.get_subscription_count():
            return
        result, self._newest = self._newest, None
        self._publisher.publish(self._make(result))
