# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes a short recording endless: played forward and backward in turn, with increasing stamps.

Reversing causes no jumps: the drone and its robots only turn around.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any

from aerial_gnss_ros.adapters.stamps import SECOND_NS, nanoseconds
from aerial_gnss_ros.bags.reader import BagReader, Recorded
from aerial_gnss_ros.core.values.errors import InputError

_LITTLE_ENDIAN = 1
_HEADER = slice(4, 12)  # seconds and nanoseconds of a header that begins a CDR message


@dataclass(frozen=True)
class Entry:
    """One recorded message.

    Attributes:
        recorded: the original message.
        at_ns: its stamp, or its arrival where it has none, since the first image, ns.
        delay_ns: from then to its arrival.
        stamped: whether it begins with a header.
    """

    recorded: Recorded
    at_ns: int
    delay_ns: int
    stamped: bool

    @property
    def topic(self) -> str:
        """Absolute name."""
        return self.recorded.topic

    def raw(self, stamp_ns: int) -> bytes:
        """Return the message as CDR with another stamp."""
        data = self.recorded.raw
        if not self.stamped:
            return data
        stamp = struct.pack("<iI", *divmod(stamp_ns, SECOND_NS))
        return b"".join((data[: _HEADER.start], stamp, memoryview(data)[_HEADER.stop :]))

    def message(self, stamp_ns: int) -> Any:
        """Return the message with another stamp; its attributes are those of rclpy's."""
        return replace(self.recorded, raw=self.raw(stamp_ns)).message()


@dataclass(frozen=True)
class Moment:
    """A message to publish.

    Attributes:
        due_ns: time of publication since the start, ns.
        stamp_ns: its stamp since the start, ns.
        entry: what.
    """

    due_ns: int
    stamp_ns: int
    entry: Entry


class Loop:
    """All messages of a bag from its first to its last image, without end.

    Args:
        bag: open.
        topics: absolute names to play.
        images: the topic of the images.

    Attributes:
        images: how many different ones there are.
        rate_hz: of the images.

    Raises:
        InputError: fewer than two images, or messages that cannot be restamped.
    """

    def __init__(self, bag: BagReader, topics: Collection[str], images: str) -> None:
        if any(path.suffix == ".bag" for path in bag.paths):
            raise InputError(f"{bag.paths[0]} is a ROS 1 bag; a rosbag2 is needed.")
        entries = [_entry(recorded) for recorded in bag.messages(set(topics))]
        stamps = [entry.at_ns for entry in entries if entry.topic == images]
        if len(stamps) < 2 or max(stamps) <= min(stamps):
            raise InputError(
                f"{', '.join(map(str, bag.paths))} has {len(stamps)} images on {images}; at least "
                "two with different stamps are needed."
            )
        self.images = len(stamps)
        self._first, self._last = min(stamps), max(stamps)
        self.rate_hz = (len(stamps) - 1) * 1e9 / (self._last - self._first)
        self._image_topic = images
        self._entries = [e for e in entries if self._first <= e.at_ns <= self._last]

    def is_image(self, moment: Moment) -> bool:
        """Return whether a message is an image."""
        return moment.entry.topic == self._image_topic

    def moments(self) -> Iterator[Moment]:
        """Yield the messages to publish, endlessly."""
        length = self._last - self._first
        there = [(entry.at_ns - self._first, entry) for entry in self._entries]
        back = [(2 * length - at, entry) for at, entry in there if 0 < at < length]
        cycle = sorted(there + back, key=lambda item: item[0] + item[1].delay_ns)
        for turn in itertools.count():
            start = 2 * length * turn
            for at, entry in cycle:
                yield Moment(start + at + entry.delay_ns, start + at, entry)


def _entry(recorded: Recorded) -> Entry:
    header = getattr(recorded.message(), "header", None)
    if header is None:
        return Entry(recorded, recorded.log_ns, 0, stamped=False)
    if recorded.raw[1] != _LITTLE_ENDIAN:
        raise InputError(f"{recorded.topic} is recorded big-endian and cannot be restamped.")
    stamp_ns = nanoseconds(header.stamp)
    return Entry(recorded, stamp_ns, recorded.log_ns - stamp_ns, stamped=True)
