# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A topic that a node listens to, and what to say when nothing comes. Knows no ROS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from aerial_gnss_ros.nodes.arrivals import SILENCE_S, Arrivals

ALWAYS, ONCE, OPTIONAL = "always", "once", "optional"


@dataclass
class Input:
    """One topic that a node listens to.

    Attributes:
        name: what comes there, in words.
        topic: resolved name.
        msgtype: such as `sensor_msgs/msg/Image`.
        expected: `always`, `once` (then it may stay silent) or `optional`.
        hint: what to look at when nothing comes though somebody publishes.
        arrivals: when messages came.
        lost: messages that were published and did not arrive, as the middleware counts them.
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
        """Whether silence on it now is worth a report."""
        return self.expected == ALWAYS or (self.expected == ONCE and self.arrivals.count == 0)

    def silence(self, publisher_types: Sequence[str], unfit: bool = False) -> str:
        """Return the sentence that reports silence.

        Args:
            publisher_types: message type of each publisher on the topic.
            unfit: whether one offers another quality of service than this node asks for.
        """
        begin = (
            f"no {self.name} for {SILENCE_S:.0f} s on {self.topic} "
            f"(publishers: {len(publisher_types)})"
        )
        other = sorted(set(publisher_types) - {self.msgtype})
        if other:
            return f"{begin}: {', '.join(other)} comes there where {self.msgtype} is meant"
        if unfit:
            return f"{begin}: its quality of service does not fit, see the message about it"
        if publisher_types:
            return f"{begin}: {self.hint}"
        return f"{begin}: start what publishes it, or remap {self.topic}"


def mismatch(topic: str, other: str, policy: str, ours: str) -> str:
    """Return the sentence that reports publisher and subscriber that do not fit.

    Args:
        topic: resolved name.
        other: `publisher` or `subscriber`, who does not fit this node.
        policy: the quality of service in question, such as `reliability`.
        ours: what this node asks for or offers; empty when the policy is none that it sets.
    """
    verb = "asks for" if other == "publisher" else "offers"
    ours = ours or "the default"
    return (
        f"{topic}: a {other} does not fit in {policy}, so nothing passes between it and this node, "
        f"which {verb} {ours}; set the {other}'s {policy} to {ours}"
    )
