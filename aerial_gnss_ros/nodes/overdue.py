# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Decides when to publish predictions without images: after 2 s, once a second."""

from __future__ import annotations

from aerial_gnss_ros.nodes.arrivals import SECOND_NS

FROM_NS = 2 * SECOND_NS
EVERY_NS = SECOND_NS


class Overdue:
    """Returns the times of due predictions, on the images' clock.

    That clock may be offset from the node's, so only elapsed node time is added. Independent of
    ROS.
    """

    def __init__(self) -> None:
        self._stamp_ns: int | None = None
        self._at_ns = 0
        self._done = 0

    def processed(self, stamp_ns: int, now_ns: int) -> None:
        """Record a processed image.

        Args:
            stamp_ns: of the image, ns.
            now_ns: node time, ns.
        """
        self._stamp_ns, self._at_ns, self._done = stamp_ns, now_ns, 0

    def seconds(self, now_ns: int) -> float:
        """Return the time since the last processed image, s; 0 before the first one."""
        elapsed_ns = now_ns - self._at_ns
        return 0.0 if self._stamp_ns is None or elapsed_ns < FROM_NS else elapsed_ns / SECOND_NS

    def due(self, now_ns: int) -> int | None:
        """Return the stamp of a prediction that is due now, ns; None while none is.

        Predictions missed because `due` was not called count as one.
        """
        if self._stamp_ns is None:
            return None
        if now_ns < self._at_ns:  # the clock was set back: the elapsed time is unknown
            self._at_ns, self._done = now_ns, 0
        elapsed_ns = now_ns - self._at_ns
        count = 0 if elapsed_ns < FROM_NS else 1 + (elapsed_ns - FROM_NS) // EVERY_NS
        if count <= self._done:
            return None
        self._done = count
        return self._stamp_ns + elapsed_ns
