# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Subscribes to topics that may be latched, whatever durability the publisher offers.

A volatile subscription matches every publisher, but does not receive earlier messages. A
transient-local subscription receives them, but matches only latching publishers, and the others
warn about it. So the second is added once the graph shows a latching publisher.
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
"""Longest time until a latching publisher is noticed."""

_REMEMBERED = 64


class Once:
    """Removes duplicates of messages received through both subscriptions. Independent of ROS.

    Both copies of a message have the source timestamp that the publisher gave it. Humble does not
    provide it: there both copies of a latched message are passed on.
    """

    def __init__(self) -> None:
        self._newest_ns = 0
        self._latched: deque[int] = deque(maxlen=_REMEMBERED)

    def directly(self, sent_ns: int) -> bool:
        """Return whether a message of the volatile subscription is new.

        Args:
            sent_ns: source timestamp, ns; 0 if the middleware gives none.
        """
        self._newest_ns = max(self._newest_ns, sent_ns)
        return not sent_ns or sent_ns not in self._latched

    def latched(self, sent_ns: int) -> bool:
        """Return whether a message of the latched subscription is new and not outdated."""
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
        receive: callback for a message.
        once: removes duplicates.
        second: the transient-local subscription; None until a publisher latches.
    """

    name: str
    resolved: str
    kind: Any
    depth: int
    receive: Callable[[Any], None]
    once: Once = field(default_factory=Once)
    second: Subscription | None = None


class LatchedToo:
    """Adds transient-local subscriptions for latching publishers.

    Args:
        node: subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._topics: dict[str, _Topic] = {}

    def watch(
        self, key: str, topic: str, kind: Any, depth: int, receive: Callable[[Any], None]
    ) -> Callable[..., None]:
        """Watch a topic and return the callback for its volatile subscription.

        Args:
            key: of the input; an existing one is replaced.
            topic: as given to the subscription, before remapping.
            kind: class of its messages.
            depth: of the queue.
            receive: called once per message.
        """
        self.forget(key)
        resolved = str(self._node.resolve_topic_name(topic))
        watched = _Topic(topic, resolved, kind, depth, receive)
        self._topics[key] = watched

        def directly(msg: Any, info: Any) -> None:
            if watched.once.directly(_sent_ns(info)):
                receive(msg)

        return with_info(directly)

    def look(self) -> None:
        """Subscribe to publishers that latch by now; call it every `LOOK_S`."""
        for topic in self._topics.values():
            if topic.second is None and self._is_latched(topic):
                topic.second = self._subscribed(topic)

    def follow(self, key: str, topic: str) -> None:
        """Switch to another topic; no effect if the input is not watched."""
        watched = self._topics.get(key)
        if watched is None:
            return
        if watched.second is not None:
            self._node.destroy_subscription(watched.second)
        watched.name, watched.resolved, watched.second = topic, topic, None

    def forget(self, key: str) -> None:
        """Stop watching an input; no effect if it is not watched."""
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
                topic.receive(msg)

        # Incompatible publishers are reported through the first subscription.
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
