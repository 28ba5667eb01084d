# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arrival statistics of one topic: count, rate, age and silence. Independent of ROS."""

from __future__ import annotations

from collections import deque

SECOND_NS = 1_000_000_000
SILENCE_S = 5.0
_WINDOW_NS = 5 * SECOND_NS
_REMEMBERED = 200


class Arrivals:
    """Arrival times of messages on a steady clock.

    Args:
        started_ns: time from which messages are expected.

    Attributes:
        count: messages so far.
        silent: whether a silence has been reported and still lasts.
    """

    def __init__(self, started_ns: int) -> None:
        self.count = 0
        self.silent = False
        self._started_ns = started_ns
        self._recent: deque[int] = deque(maxlen=_REMEMBERED)

    def record(self, now_ns: int) -> float | None:
        """Record a message; return the duration of the silence it ends, s; None without one."""
        quiet_s = self.quiet_s(now_ns)
        was_silent, self.silent = self.silent, False
        self.count += 1
        self._recent.append(now_ns)
        return quiet_s if was_silent else None

    def quiet_s(self, now_ns: int) -> float:
        """Return the seconds since the last message, or since the start."""
        last = self._recent[-1] if self._recent else self._started_ns
        return (now_ns - last) / SECOND_NS

    def age_s(self, now_ns: int) -> float | None:
        """Return the seconds since the last message, None before the first one."""
        return self.quiet_s(now_ns) if self._recent else None

    def rate(self, now_ns: int) -> float:
        """Return messages per second over the last five seconds."""
        recent = [stamp for stamp in self._recent if now_ns - stamp <= _WINDOW_NS]
        if len(recent) < 2 or recent[-1] == recent[0]:
            return 0.0
        return (len(recent) - 1) * SECOND_NS / (recent[-1] - recent[0])

    def fell_silent(self, now_ns: int) -> bool:
        """Return True once per silence, when it is long enough to be reported."""
        if self.silent or self.quiet_s(now_ns) < SILENCE_S:
            return False
        self.silent = True
        return True
