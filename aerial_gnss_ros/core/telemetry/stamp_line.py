# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sequence of stamps of one input that follow one another.

The network may delay a message by any amount, and after a congestion the delay falls again, but
never below its minimum. So a stamp that is ahead of the node's clock by more than any before is
early for another reason, unless the network was congested from the start.
"""

from __future__ import annotations

from dataclasses import dataclass

LATE_NS = 2_000_000_000
"""Greatest age of a message behind the newest one of its input, ns."""

AHEAD_NS = 2_000_000_000
"""Greatest lead of a stamp over the newest one plus the elapsed time, ns."""

EARLY_NS = 500_000_000
"""Greatest increase of a stamp's lead over the node's clock, ns."""

DRIFT_NS = 60_000_000_000
"""Decrease of the lead over the node's clock from which that clock was set, ns."""


@dataclass
class Line:
    """Stamps that follow one another.

    Attributes:
        first_ns: the first one, ns.
        newest_ns: the newest one, ns.
        leads: whether it began ahead of another sequence by at most `AHEAD_NS`.
        step_ns: from the newest but one to the newest, ns; as yet `AHEAD_NS`.
        offset_ns: greatest lead of its stamps over the node's clock, ns; None: unknown.
        told_ns: node's clock at the newest one, ns; None: unknown.
        begun_ns: node's clock at the first one, ns; None: unknown.
        count: of stamps.
    """

    first_ns: int
    newest_ns: int
    leads: bool = False
    step_ns: int = AHEAD_NS
    offset_ns: int | None = None
    told_ns: int | None = None
    begun_ns: int | None = None
    count: int = 0
    _untold_ns: int | None = None

    def goes_on(self, stamp_ns: int, now_ns: int | None) -> bool:
        """Return whether a stamp follows the newest one."""
        return stamp_ns >= self.newest_ns - LATE_NS and not self.is_behind(stamp_ns, now_ns)

    def is_behind(self, stamp_ns: int, now_ns: int | None) -> bool:
        """Return whether a stamp is too far ahead for the elapsed time."""
        if now_ns is None or self.offset_ns is None:
            return stamp_ns > self.newest_ns + AHEAD_NS
        # Stamps at their usual spacing are not early, however fast they arrive.
        usual_ns = self.newest_ns + min(self.step_ns + EARLY_NS, AHEAD_NS)
        return stamp_ns > max(usual_ns, now_ns + self.offset_ns + EARLY_NS)

    def is_led(self, stamp_ns: int, now_ns: int | None) -> bool:
        """Return whether a stamp that is too far ahead is so by at most `AHEAD_NS`."""
        if stamp_ns < self.newest_ns or now_ns is None or self.offset_ns is None:
            return False
        return stamp_ns <= max(self.newest_ns, now_ns + self.offset_ns) + AHEAD_NS

    def add(self, stamp_ns: int) -> None:
        """Add a stamp; `note_arrival` follows."""
        self.count += 1
        if stamp_ns > self.newest_ns:
            self.step_ns, self.newest_ns = stamp_ns - self.newest_ns, stamp_ns
            self.told_ns = None
        if self._untold_ns is None or stamp_ns > self._untold_ns:
            self._untold_ns = stamp_ns

    def note_arrival(self, now_ns: int) -> None:
        """Record the arrival time of the stamps since the last call."""
        stamp_ns, self._untold_ns = self._untold_ns, None
        if self.told_ns is None:
            self.told_ns = now_ns
        if self.begun_ns is None:
            self.begun_ns = now_ns
        if stamp_ns is None:
            return
        offset_ns, known = stamp_ns - now_ns, self.offset_ns
        if known is None or offset_ns > known or offset_ns < known - DRIFT_NS:
            self.offset_ns = offset_ns

    def expected_ns(self, now_ns: int | None) -> int:
        """Return the stamp expected now."""
        if now_ns is None or self.told_ns is None:
            return self.newest_ns
        return self.newest_ns + max(0, now_ns - self.told_ns)

    @property
    def heard(self) -> bool:
        """Whether a stamp has arrived since the node's clock was set back."""
        return self.offset_ns is not None or self._untold_ns is not None

    @property
    def span_s(self) -> float:
        """Time between its first and its newest stamp, s."""
        return (self.newest_ns - self.first_ns) * 1e-9
