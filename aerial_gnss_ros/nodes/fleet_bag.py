# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One recording for each of several drones, as one, each below its drone's name.

Independent of ROS.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from operator import attrgetter

from aerial_gnss_ros.bags.reader import BagReader, Recorded
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes.played_topics import GLOBAL, moved


class FleetBag:
    """What a player needs of a `BagReader`; topics that no namespace applies to are left out.

    Args:
        bags: open, by the drone's name.

    Attributes:
        paths: of all bags.
        topics: by name below the drone's.
        start_ns: log time of the first message of all, ns.
        end_ns: of the last one.

    Raises:
        InputError: two recordings have no moment in common, so their stamps are of two clocks.
    """

    def __init__(self, bags: Mapping[str, BagReader]) -> None:
        self._bags = dict(bags)
        self.paths = [path for bag in bags.values() for path in bag.paths]
        self._own = {
            moved(name, drone): (drone, name)
            for drone, bag in bags.items()
            for name in bag.topics
            if name not in GLOBAL
        }
        self.topics = {
            name: replace(bags[drone].topics[own], name=name)
            for name, (drone, own) in self._own.items()
        }
        self.start_ns = min(bag.start_ns for bag in bags.values())
        self.end_ns = max(bag.end_ns for bag in bags.values())
        if max(bag.start_ns for bag in bags.values()) > min(bag.end_ns for bag in bags.values()):
            raise InputError(
                "the recordings have no moment in common: they cannot be played together."
            )

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Recorded]:
        """Yield the messages of all bags in the order of log times.

        Args:
            topics: to read; None: all.
        """
        wanted = self._own if topics is None else {one: self._own[one] for one in topics}
        parts = [
            self._of(drone, {own: name for name, (of, own) in wanted.items() if of == drone})
            for drone in self._bags
        ]
        yield from heapq.merge(*parts, key=attrgetter("log_ns"))

    def _of(self, drone: str, names: Mapping[str, str]) -> Iterator[Recorded]:
        """Yield the messages of a drone's bag; `names` are those below the drone's, by its own."""
        if names:
            for recorded in self._bags[drone].messages(set(names)):
                yield replace(recorded, topic=names[recorded.topic])
