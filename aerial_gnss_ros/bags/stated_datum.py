# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Altitude datum stated by a simulated recording, used if the user states none."""

from __future__ import annotations

from dataclasses import replace

from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.text.json_text import parse_json

_SCENARIO, _TEXT = "/truth/scenario", "std_msgs/msg/String"


def with_stated_datum(config: EstimatorConfig, bag: BagReader) -> EstimatorConfig:
    """Return a configuration with fixes above the ellipsoid if the recording says so.

    Args:
        config: unchanged if it names a datum.
        bag: open; a simulated one has a scenario.

    Raises:
        InputError: the bag is damaged.
    """
    if config.fix.altitude_datum != "unknown" or not _states_ellipsoid(bag):
        return config
    return replace(config, fix=replace(config.fix, altitude_datum="ellipsoid"))


def _states_ellipsoid(bag: BagReader) -> bool:
    names = {
        topic.name
        for topic in bag.topics.values()
        if topic.name.endswith(_SCENARIO) and topic.msgtype == _TEXT
    }
    first = next(iter(bag.messages(names)), None) if names else None
    if first is None:
        return False
    try:
        about = parse_json(first.message().data)
        return bool(about["altitude_datum"] == "ellipsoid")
    except (ValueError, KeyError, TypeError):
        return False
