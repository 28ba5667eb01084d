# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Receives what may be sent once and latched, whatever durability its publisher offers.

A volatile subscription matches every publisher, but never gets what was sent before it. One that
asks for transient local gets that, but matches only publishers that latch, and makes the others
warn of it. So the second is added where the graph shows a publisher that latches.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription

from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.distribution import SubscriptionEventCallbacks, with_info

LOOK_S = 0.25
"""How long a latched message waits at most until its publisher is noticed."""

_REMEMBERED = 64


class Once:
    """Tells messages that come first from their copies. Knows no ROS.

    A message that is received twice has one source timestamp, which its publisher gave it. Humble
    does not tell it: there the copies of a publisher that latches are taken, too.
    """

    def __init__(self) -> None:
        self._newest_ns = 0
        self._latched: deque[int] = deque(maxlen=_REMEMBERED)

    def directly(self, sent_ns: int) -> bool:
        """Return whether to take a message of the volatile subscription.

        Args:
            sent_ns: source timestamp, ns; 0 where the middleware gives none.
        """
        self._newest_ns = max(self._newest_ns, sent_ns)
        return not sent_ns or sent_ns not in self._latched

    def latched(self, sent_ns: int) -> bool:
        """Return whether to take a message of the other one: it must not replace a newer one."""
        if sent_ns and sent_ns <= self._newest_ns:
            return False
        self._newest_ns = sent_ns
        self._latched.append(sent_ns)
        return True


@dataclass
class _Topic:
    """A topic that may be latched.

    Attributes:
        name: as given, before remapping.
        resolved: full name.
        kind: class of its messages.
        depth: of the queue.
        take: takes a message.
        once: which messages are new.
        second: the subscription that asks for transient local; None until a publisher latches.
    """

    name: str
    resolved: str
    kind: Any
    depth: int
    take: Callable[[Any], None]
    once: Once = field(default_factory=Once)
    second: Subscription | None = None


class LatchedToo:
    """Adds subscriptions to publishers that latch.

    Args:
        node: subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._topics: dict[str, _Topic] = {}

    def watch(
        self, key: str, topic: str, kind: Any, depth: int, take: Callable[[Any], None]
    ) -> Callable[..., None]:
        """Watch a topic and return the callback for its volatile subscription.

        Args:
            key: of the input; one that is watched already is replaced.
            topic: as given to the subscription, before remapping.
            kind: class of its messages.
            depth: of the queue.
            take: takes each message once.
        """
        self.forget(key)
        resolved = str(self._node.resolve_topic_name(topic))
        watched = _Topic(topic, resolved, kind, depth, take)
        self._topics[key] = watched

        def directly(msg: Any, info: Any) -> None:
            if watched.once.directly(_sent_ns(info)):
                take(msg)

        return with_info(directly)

    def look(self) -> None:
        """Subscribe where a publisher latches by now; call it every `LOOK_S`."""
        for topic in self._topics.values():
            if topic.second is None and self._is_latched(topic):
                topic.second = self._subscribed(topic)

    def follow(self, key: str, topic: str) -> None:
        """Go over to another topic; nothing where the former is not watched."""
        watched = self._topics.get(key)
        if watched is None:
            return
        if watched.second is not None:
            self._node.destroy_subscription(watched.second)
        watched.name, watched.resolved, watched.second = topic, topic, None

    def forget(self, key: str) -> None:
        """End watching a topic; nothing where it is not watched."""
        topic = self._topics.pop(key, None)
        if topic is not None and topic.second is not None:
            self._node.destroy_subscription(topic.second)

    def _is_latched(self, topic: _Topic) -> bool:
        found = self._node.get_publishers_info_by_topic(topic.resolved)
        wanted = qos.sent_before(topic.depth)
        return any(
            info.qos_profile.durability == wanted.durability
            and info.qos_profile.reliability == wanted.reliability
            for info in found
        )

    def _subscribed(self, topic: _Topic) -> Subscription:
        def latched(msg: Any, info: Any) -> None:
            if topic.once.latched(_sent_ns(info)):
                topic.take(msg)

        # The node reports publishers that do not fit by its first subscription.
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self._node.create_subscription(
            topic.kind,
            topic.name,
            with_info(latched),
            qos.sent_before(topic.depth),
            event_callbacks=silent,
        )


def _sent_ns(info: Any) -> int:
    """Return the source timestamp of a message's info, which rclpy gives as a dict."""
    return int(info.get("source_timestamp", 0))
