# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether bags that are read together are of one drone.

Two recorders of one drone store the same messages. Recordings of two drones have none in common,
and read as one they give a drone that is in two places at a time.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations
from pathlib import Path

from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.core.values.errors import InputError

_COMPARED_NS = 30_000_000_000
"""Time compared, from where both bags have begun: clocks of two recorders may differ by less."""
_LEAST = 10
"""Least number of messages in each: fewer may all have been lost by one of two recorders."""


def refuse_two_drones(bag: BagReader, topics: Collection[str]) -> None:
    """Refuse bags that have different messages on one topic at one time.

    Args:
        bag: open.
        topics: of the drone's position, absolute.

    Raises:
        InputError: names two bags, and what to do.
    """
    for (first, (begin, end)), (second, (start, stop)) in combinations(bag.spans.items(), 2):
        both_ns = max(begin, start), min(end, stop)
        for topic in topics if both_ns[0] < both_ns[1] else ():
            last_ns = min(both_ns[1], both_ns[0] + _COMPARED_NS)
            found: dict[Path, set[bytes]] = {first: set(), second: set()}
            for recorded in bag.messages([topic], both_ns[0], last_ns):
                if recorded.path in found:
                    found[recorded.path].add(recorded.raw)
            one, other = found.values()
            if min(len(one), len(other)) >= _LEAST and not one & other:
                raise InputError(
                    f"{first} and {second} have different messages on {topic} at the same time: "
                    "they are of two drones; give each one as --drone NAME=BAG, or those of one "
                    "drone only."
                )
