# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images that wait for the telemetry of their scenes, in the order of their stamps."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.rejection import Input

MAX_WAITING = 4096
"""Greatest number of waiting images: 30 s at 130 Hz. Older ones are refused to bound memory."""


@dataclass
class WaitingImage:
    """A waiting image.

    Attributes:
        frame: its boxes.
        newest_ns: the newest time of each input when it arrived, ns.
        since_ns: node time from which it waits, ns; None: not yet set.
    """

    frame: DetectionFrame
    newest_ns: Mapping[Input, int] = field(default_factory=dict)
    since_ns: int | None = None


def _stamp(image: WaitingImage) -> int:
    return image.frame.stamp_ns


class ImageQueue:
    """Sorts images by stamp; those older than the last processed one are dropped.

    Args:
        dropped: counts `duplicate` and `out_of_order` images.

    Attributes:
        waiting: the images, the oldest first.
        last_ns: stamp of the last removed image, ns; None before the first.
    """

    def __init__(self, dropped: Counter[str]) -> None:
        self.waiting: list[WaitingImage] = []
        self.last_ns: int | None = None
        self._dropped = dropped

    def add(self, frame: DetectionFrame, newest_ns: Mapping[Input, int]) -> bool:
        """Queue an image; return whether too many wait.

        Args:
            frame: its boxes.
            newest_ns: the newest time of each input now, ns.
        """
        stamp_ns, waiting = frame.stamp_ns, self.waiting
        place = bisect_left(waiting, stamp_ns, key=_stamp)
        waits = place < len(waiting) and _stamp(waiting[place]) == stamp_ns
        if waits or stamp_ns == self.last_ns:
            self._dropped["duplicate"] += 1
        elif self.last_ns is not None and stamp_ns < self.last_ns:
            self._dropped["out_of_order"] += 1
        else:
            waiting.insert(place, WaitingImage(frame, newest_ns))
        return len(waiting) > MAX_WAITING

    def tick(self, now_ns: int) -> None:
        """Set the node time from which images wait."""
        for image in self.waiting:
            if image.since_ns is None or image.since_ns > now_ns:  # the clock was set back
                image.since_ns = now_ns

    def is_late(self, now_ns: int, patience_ns: int) -> bool:
        """Return whether the first image has waited long enough.

        Args:
            now_ns: node time, ns.
            patience_ns: longest wait of an image, ns.
        """
        since_ns = self.waiting[0].since_ns
        return since_ns is not None and now_ns - since_ns >= patience_ns

    def pop(self) -> None:
        """Remove and return the first image."""
        self.last_ns = self.waiting.pop(0).frame.stamp_ns

    def time_before(self, stamp_ns: int) -> int | None:
        """Return a stamp, or one before the waiting images; None if none is after `last_ns`.

        Args:
            stamp_ns: ns.
        """
        if self.waiting:
            stamp_ns = min(stamp_ns, _stamp(self.waiting[0]) - 1)
        return None if self.last_ns is None or stamp_ns <= self.last_ns else stamp_ns
