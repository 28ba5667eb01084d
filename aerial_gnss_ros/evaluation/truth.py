# SPDX-License-Identifier: Apache-2.0
"""Truth from a bag: `truth/robots/<id>/fix`, and the drone's `truth/fix` if simulated."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.bags.tables import Track

_ROBOT = re.compile(r"(?P<namespace>.*)/truth/robots/(?P<name>[^/]+)/fix")
_DRONE = re.compile(r".*/truth/fix")
_FIX = "sensor_msgs/msg/NavSatFix"


@dataclass(frozen=True)
class Truth:
    """Where everything really was.

    Attributes:
        robots: tracks by the truth's own names; empty where the bag has no truth.
        drone: the drone's path, or None.
    """

    robots: dict[str, Track] = field(default_factory=dict)
    drone: Track | None = None


def read_truth(bag: BagReader) -> Truth:
    """Read the truth topics of a bag; a bag without them has an empty truth.

    Raises:
        InputError: the bag is damaged.
    """
    names: dict[str, str | None] = {}
    for topic in bag.topics.values():
        robot = _ROBOT.fullmatch(topic.name)
        if topic.msgtype == _FIX and (robot or _DRONE.fullmatch(topic.name)):
            names[topic.name] = robot["name"] if robot else None
    rows: dict[str, list[tuple[int, float, float]]] = {name: [] for name in names}
    if names:
        for recorded in bag.messages(set(names)):
            fix = recorded.message()
            rows[recorded.topic].append(
                (nanoseconds(fix.header.stamp), fix.latitude, fix.longitude)
            )
    robots = {name: track(rows[t]) for t, name in names.items() if name is not None and rows[t]}
    drone = next((track(rows[t]) for t, name in names.items() if name is None and rows[t]), None)
    return Truth(dict(sorted(robots.items())), drone)


def track(rows: Sequence[tuple[int, float, float]]) -> Track:
    """Return a track of (stamp in ns, latitude and longitude in degrees), ordered by stamp."""
    ordered = sorted(rows)
    stamps = np.array([row[0] for row in ordered], dtype=np.int64)
    places = np.array([row[1:] for row in ordered]).reshape(-1, 2) * (math.pi / 180.0)
    return Track(stamps, places[:, 0], places[:, 1])
