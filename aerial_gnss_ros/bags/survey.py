# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lists a bag's topics with their rates, and those of unknown types."""

from __future__ import annotations

from aerial_gnss_ros.adapters.matching import SeenTopic
from aerial_gnss_ros.bags.reader import BagReader, Topic
from aerial_gnss_ros.bags.typestore import typestore
from aerial_gnss_ros.core.values.errors import InputError


def survey(bag: BagReader) -> list[SeenTopic]:
    """Return the topics with messages; one message of each unknown type is tried."""
    seconds = (bag.end_ns - bag.start_ns) * 1e-9
    return [
        SeenTopic(
            topic.name,
            topic.msgtype,
            (topic.count - 1) / seconds if seconds > 0.0 else 0.0,
            topic.count,
            _trouble(bag, topic),
        )
        for topic in bag.topics.values()
        if topic.count
    ]


def _trouble(bag: BagReader, topic: Topic) -> str:
    if topic.msgtype in typestore().fielddefs:
        return ""
    try:
        next(bag.messages({topic.name})).message()
    except InputError as error:
        return str(error)
    return ""
