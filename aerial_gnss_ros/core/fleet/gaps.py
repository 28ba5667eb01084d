# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which of a drone's sightings have arrived ashore, and which it is to send again.

What the drone still has from before the first one that arrives is asked for as well: a fleet that
begins in flight then knows the last minute.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.fleet.outbox import SECOND_NS, SentSighting
from aerial_gnss_ros.core.fleet.outbox import TUNING as OUTBOX


@dataclass(frozen=True)
class GapsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    again_s: float = 2.0
    """Time after which a sighting that has not come is asked for again, s, besides the time for
    request and answer. Judged."""
    longest_s: float = 5.0
    """Longest delay of a link that is waited for, s: a wrong clock looks like one. Judged."""
    rate_hz: float = 100.0
    """Rate at which a drone sends again; see `nodes.sightings`."""


TUNING = GapsTuning()


class Gaps:
    """Sequence numbers of one drone, in any order and any number of times.

    Attributes:
        session: of the drone; None before its first sighting.
        lost: number of sightings that the drone has given up before they arrived.
        repeated: number of those that arrived again.
    """

    def __init__(self) -> None:
        self.session: int | None = None
        self.lost = self.repeated = 0
        self._newest = -1
        self._missing: dict[int, int] = {}  # when each is to be asked for, ns

    def take(self, sent: SentSighting) -> bool:
        """Note a sighting; return whether it is new, and not of a session that has ended."""
        if self.session is None or sent.session > self.session:
            self.lost += len(self._missing)
            self.session, self._newest = sent.session, sent.sequence
            oldest = max(sent.oldest, sent.sequence - OUTBOX.most)
            self._missing = dict.fromkeys(range(oldest, sent.sequence), 0)
            return True
        if sent.session < self.session:
            self.repeated += 1
            return False
        number = sent.sequence
        self._give_up(sent.oldest)
        if number > self._newest:
            begin = self._newest + 1
            kept = max(begin, sent.oldest, number - OUTBOX.most)
            self.lost += kept - begin
            self._missing |= dict.fromkeys(range(kept, number), 0)
            self._newest = number
            return True
        if number not in self._missing:
            self.repeated += 1
            return False
        del self._missing[number]
        return True

    def _give_up(self, oldest: int) -> None:
        """Forget what the drone has given up."""
        gone = [number for number in self._missing if number < oldest]
        self.lost += len(gone)
        for number in gone:
            del self._missing[number]

    @property
    def missing(self) -> int:
        """Number of sightings that are wanted again."""
        return len(self._missing)

    def wanted(self, now_ns: int, most: int = 20, delay_s: float = 0.0) -> list[tuple[int, int]]:
        """Return the first and last numbers to ask for, the oldest first.

        What has been asked for is not asked for again before it can have come.

        Args:
            now_ns: of a clock that is never stepped, ns.
            most: greatest number of pairs.
            delay_s: of the link, one way, s; NaN if it is not known.
        """
        found: list[tuple[int, int]] = []
        travels_s = (
            2.0 * min(max(delay_s, 0.0), TUNING.longest_s) if math.isfinite(delay_s) else 0.0
        )
        again_s = TUNING.again_s + travels_s + 2.0 * len(self._missing) / TUNING.rate_hz
        again_ns = now_ns + round(again_s * SECOND_NS)
        for number in sorted(self._missing):
            if self._missing[number] > now_ns:
                continue
            if found and number == found[-1][1] + 1:
                found[-1] = found[-1][0], number
            elif len(found) == most:
                break
            else:
                found.append((number, number))
            self._missing[number] = again_ns
        return found
