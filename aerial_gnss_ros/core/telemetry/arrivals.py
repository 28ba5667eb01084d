# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Admission of messages by stamp: those with outlying stamps wait until the clock decides."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping
from typing import Protocol

from aerial_gnss_ros.core.telemetry.clock import DETECTIONS, Clock
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision, Verdict
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.text.sentences import counted

MAX_HELD = 4096
"""Greatest number of waiting messages; the oldest are refused."""

WRONG_STAMP, NO_STAMP = "wrong_stamp", "no_stamp"

UNFILLED_NS = 0
"""Stamp of a message whose sender filled none in, ns: the default of ROS messages."""


class Counted(Protocol):
    """Counts the messages of one input."""

    def refuse(self, trouble: str) -> None:
        """Count an unusable message; `trouble` says why."""

    def undo_refusal(self) -> None:
        """Take back a refusal: the message is usable after all."""


class Arrivals:
    """Admits messages whose stamps continue their input's sequence.

    Args:
        clock: judges stamps.
        tallies: count messages, by input.
        dropped: counts images.
        log: receives sentences about refusals.
        reset_time: called before messages of a new time are admitted.
        tell_lead: called after inputs were admitted whose stamps lead those of the images from now
            on.
    """

    def __init__(
        self,
        clock: Clock,
        tallies: Mapping[str, Counted],
        dropped: Counter[str],
        log: Events,
        reset_time: Callable[[Decision], None],
        tell_lead: Callable[[], None] | None = None,
    ) -> None:
        self._clock = clock
        self._tallies = tallies
        self._dropped = dropped
        self._log = log
        self._reset_time, self._tell_lead = reset_time, tell_lead
        self._held: deque[tuple[str, int, Callable[[], None]]] = deque()
        self._apart_s: dict[str, float] = {}

    def receive(self, name: str, stamp_ns: int, keep: Callable[[], None]) -> None:
        """Admit, hold or refuse a message.

        Args:
            name: of its input.
            stamp_ns: its stamp, ns.
            keep: stores it.
        """
        # What holds until replaced needs no time: without a stamp it holds from the beginning.
        if stamp_ns == UNFILLED_NS and name not in self._clock.held:
            self._refuse_unfilled(name)
            return
        verdict = self._clock.judge(name, stamp_ns)
        if verdict in (Verdict.RETURNS, Verdict.ELSEWHERE):
            self._refuse(name)
        if verdict in (Verdict.RETURNS, Verdict.GOES_ON):
            keep()
        else:
            self._hold(name, stamp_ns, keep)

    def tick(self, now_ns: int, stepped_ns: int = 0) -> None:
        """Update the node's time.

        Args:
            now_ns: node time, ns.
            stepped_ns: by how much it was set since the last call, ns.
        """
        self._clock.tick(now_ns)
        if stepped_ns:
            self._clock.step(stepped_ns)
        if self._held:  # otherwise no stamp is an outlier
            self._let_silent_in()

    def flush(self) -> None:
        """Refuse all waiting messages at the end of input."""
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
            self._reset_time(decision)
            self._clock.believe(decision)
            self._let_in(None if decision.time_reset else decision.moved)

    def _refuse(self, name: str) -> None:
        """Refuse an input's waiting messages."""
        count = sum(held == name for held, _, _ in self._held)
        self._held = deque(one for one in self._held if one[0] != name)
        if name == DETECTIONS:
            self._dropped[WRONG_STAMP] += count
        apart_s = self._apart_s.pop(name, 0.0)
        self._log.warn_once(
            f"stamps {name}",
            f"{counted(count, 'message')} on {name} refused: stamped {abs(apart_s):.1f} s "
            f"{_side(apart_s)}, while other inputs continued. Check the clock that stamps it.",
        )

    def _refuse_unfilled(self, name: str) -> None:
        """Refuse a message without a stamp: nobody knows which time it belongs to."""
        self._tallies[name].refuse("its stamp is 0, which its sender never filled in")
        if name == DETECTIONS:
            self._dropped[NO_STAMP] += 1
        self._log.warn_once(
            f"unfilled {name}",
            f"Messages on {name} are refused: their stamp is 0, which their sender never filled "
            f"in; {_unfilled_advice(name)}.",
        )

    def _let_silent_in(self) -> None:
        silent = self._clock.silent()
        led = {name: self._clock.apart_s(name) for name in silent if self._clock.leads(name)}
        for name in silent:
            self._clock.goes_on(name)
        if silent:
            self._let_in(silent)
        first = next((name for name in led if name in self._clock.needed), None)
        if first is None or DETECTIONS in led:
            return
        self._log.warn_once(
            "lead",
            f"Stamps of telemetry ({first} first) are {led[first]:.1f} s farther ahead of their "
            "arrival than before, those of images are not: a clock was set, or the network was "
            "congested until now. Whether latencies are as configured is asked anew.",
        )
        if self._tell_lead is not None:
            self._tell_lead()

    def _let_in(self, names: tuple[str, ...] | None) -> None:
        """Admit the waiting messages of some inputs, or of all."""
        waiting, self._held = self._held, deque()
        for name, stamp_ns, keep in waiting:
            if names is not None and name not in names:
                self._held.append((name, stamp_ns, keep))
            else:
                self._tallies[name].undo_refusal()
                self.receive(name, stamp_ns, keep)


def _unfilled_advice(name: str) -> str:
    """Return what to check where an input has no stamps."""
    if name == DETECTIONS:
        return "detections have the stamp of their image: check the camera's driver"
    if name in {source.value for source in Input}:
        return f"check its driver, or set {name}.stamp to arrival"
    return "check its driver"


def _side(apart_s: float) -> str:
    return "ahead of those before" if apart_s > 0.0 else "behind those before"
