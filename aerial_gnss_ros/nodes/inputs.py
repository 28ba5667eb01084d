# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A topic that a node subscribes to, and the report of its silence. Independent of ROS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from aerial_gnss_ros.nodes.arrivals import SILENCE_S, Arrivals

ALWAYS, ONCE, OPTIONAL = "always", "once", "optional"


@dataclass
class Input:
    """One topic that a node subscribes to.

    Attributes:
        name: its content, in words.
        topic: resolved name.
        msgtype: such as `sensor_msgs/msg/Image`.
        expected: `always`, `once` (then it may stay silent) or `optional`.
        hint: what to check if nothing arrives although there is a publisher.
        arrivals: statistics of its messages.
        lost: messages lost in transport, as counted by the middleware.
    """

    name: str
    topic: str
    msgtype: str
    expected: str
    hint: str
    arrivals: Arrivals
    lost: int = 0

    @property
    def missed(self) -> bool:
        """Whether silence on it should be reported."""
        return self.expected == ALWAYS or (self.expected == ONCE and self.arrivals.count == 0)

    def silence(self, publisher_types: Sequence[str], unfit: bool = False) -> str:
        """Return the sentence that reports silence.

        Args:
            publisher_types: message type of each publisher on the topic.
            unfit: whether a publisher offers an incompatible quality of service.
        """
        begin = (
            f"no {self.name} for {SILENCE_S:.0f} s on {self.topic} "
            f"(publishers: {len(publisher_types)})"
        )
        other = sorted(set(publisher_types) - {self.msgtype})
        if other:
            return f"{begin}: {', '.join(other)} is published there instead of {self.msgtype}"
        if unfit:
            return f"{begin}: its quality of service is incompatible, see the message about it"
        if publisher_types:
            return f"{begin}: {self.hint}"
        return f"{begin}: start its publisher, or remap {self.topic}"


def mismatch(topic: str, other: str, policy: str, ours: str) -> str:
    """Return the sentence that reports an incompatible publisher or subscriber.

    Args:
        topic: resolved name.
        other: `publisher` or `subscriber`, whichever is incompatible with this node.
        policy: the quality of service in question, such as `reliability`.
        ours: what this node requests or offers; empty if it does not set the policy.
    """
    verb = "asks for" if other == "publisher" else "offers"
    ours = ours or "the default"
    return (
        f"{topic}: a {other} has an incompatible {policy}, so nothing passes between it and this "
        f"node, which {verb} {ours}; set the {other}'s {policy} to {ours}"
    )
