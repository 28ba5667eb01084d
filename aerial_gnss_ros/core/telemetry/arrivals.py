# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages on their way in: those whose stamps are far off wait until it is known what they are."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping
from typing import Protocol

from aerial_gnss_ros.core.telemetry.clock import DETECTIONS, Clock
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision, Verdict
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.text.sentences import counted

MAX_HELD = 4096
"""Messages that wait at most; the oldest are refused."""

WRONG_STAMP = "wrong_stamp"


class Counted(Protocol):
    """Counts the messages of one input."""

    def refuse(self, trouble: str) -> None:
        """Count a message that is no use; `trouble` says why."""

    def undo_refusal(self) -> None:
        """Take back a message that was refused: it is of use after all."""


class Arrivals:
    """Lets messages in whose stamps go on.

    Args:
        clock: judges stamps.
        tallies: count messages, by input.
        dropped: counts images.
        log: is told what is refused.
        begin_anew: is called before what moved in time is let in.
    """

    def __init__(
        self,
        clock: Clock,
        tallies: Mapping[str, Counted],
        dropped: Counter[str],
        log: Events,
        begin_anew: Callable[[Decision], None],
    ) -> None:
        self._clock = clock
        self._tallies = tallies
        self._dropped = dropped
        self._log = log
        self._begin_anew = begin_anew
        self._held: deque[tuple[str, int, Callable[[], None]]] = deque()
        self._apart_s: dict[str, float] = {}

    def take(self, name: str, stamp_ns: int, keep: Callable[[], None]) -> None:
        """Take in a message.

        Args:
            name: of its input.
            stamp_ns: its stamp, ns.
            keep: keeps it.
        """
        verdict = self._clock.take(name, stamp_ns)
        if verdict in (Verdict.RETURNS, Verdict.ELSEWHERE):
            self._refuse(name)
        if verdict in (Verdict.RETURNS, Verdict.GOES_ON):
            keep()
        else:
            self._hold(name, stamp_ns, keep)

    def tick(self, now_ns: int, stepped_ns: int = 0) -> None:
        """Take in the node's time.

        Args:
            now_ns: it, ns.
            stepped_ns: by how much it was set since it was taken in last, ns.
        """
        self._clock.tick(now_ns)
        if stepped_ns:
            self._clock.step(stepped_ns)
        if self._held:  # else no stamp is far off
            self._let_silent_in()

    def flush(self) -> None:
        """Refuse what still waits: nothing more comes."""
        self._let_silent_in()
        for name in dict.fromkeys(name for name, _, _ in self._held):
            self._refuse(name)

    def _hold(self, name: str, stamp_ns: int, keep: Callable[[], None]) -> None:
        self._held.append((name, stamp_ns, keep))
        apart_s = self._apart_s[name] = self._clock.apart_s(name)
        self._tallies[name].refuse(f"its stamp is {abs(apart_s):.1f} s {_side(apart_s)}")
        if len(self._held) > MAX_HELD:
            self._held.popleft()
        decision = self._clock.decision(name)
        if decision is not None:
            self._begin_anew(decision)
            self._clock.believe(decision)
            self._let_in(None if decision.anew else decision.moved)

    def _refuse(self, name: str) -> None:
        """Refuse what waits of an input."""
        count = sum(held == name for held, _, _ in self._held)
        self._held = deque(one for one in self._held if one[0] != name)
        if name == DETECTIONS:
            self._dropped[WRONG_STAMP] += count
        apart_s = self._apart_s.pop(name, 0.0)
        self._log.warn_once(
            f"stamps {name}",
            f"{counted(count, 'message')} on {name} refused: stamped {abs(apart_s):.1f} s "
            f"{_side(apart_s)}, while other inputs went on. Look at the clock that stamps it.",
        )

    def _let_silent_in(self) -> None:
        silent = self._clock.silent()
        for name in silent:
            self._clock.goes_on(name)
        if silent:
            self._let_in(silent)

    def _let_in(self, names: tuple[str, ...] | None) -> None:
        """Take in what waits of some inputs, or of all."""
        waiting, self._held = self._held, deque()
        for name, stamp_ns, keep in waiting:
            if names is not None and name not in names:
                self._held.append((name, stamp_ns, keep))
            else:
                self._tallies[name].undo_refusal()
                self.take(name, stamp_ns, keep)


def _side(apart_s: float) -> str:
    return "ahead of those before" if apart_s > 0.0 else "behind those before"
