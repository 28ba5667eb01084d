# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects that a node's clock was set, by comparison with a monotonic clock."""

from __future__ import annotations

STEP_NS = 2_000_000_000
"""Difference between the clocks' increments beyond which one was set, ns."""

WINDOW_NS = 2_000_000_000
"""Time over which both must have agreed before, ns."""

ALIKE = 0.2
"""Relative tolerance of that agreement; simulated time may run faster, and then nothing is
known."""


class Steady:
    """Compares two clocks.

    Attributes:
        now_ns: last reading of the monotonic clock, ns; None: there is none.
    """

    def __init__(self) -> None:
        self.now_ns: int | None = None
        self._last: tuple[int, int] | None = None
        self._since: tuple[int, int] | None = None
        self._alike = False

    def update(self, clock_ns: int, steady_ns: int | None) -> int:
        """Compare readings of both; return by how much the clock was set, 0 if it was not.

        Args:
            clock_ns: of the clock that may be set, ns.
            steady_ns: of the monotonic clock, None without one, ns.
        """
        self.now_ns = steady_ns
        if steady_ns is None:
            return 0
        now = (clock_ns, steady_ns)
        last, self._last = self._last or now, now
        by_ns = (clock_ns - last[0]) - (steady_ns - last[1])
        if abs(by_ns) > STEP_NS:
            alike, self._since = self._alike, now
            return by_ns if alike else 0
        since = self._since = self._since or now
        passed = steady_ns - since[1]
        if passed >= WINDOW_NS:
            self._alike = abs(clock_ns - since[0] - passed) <= ALIKE * passed
            self._since = now
        return 0

    def since_s(self, before_ns: int | None) -> float | None:
        """Return the time since a reading of the monotonic clock, s; None if unknown."""
        if self.now_ns is None or before_ns is None or not self._alike:
            return None
        return (self.now_ns - before_ns) * 1e-9
