# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Decides which stamps to trust, and whether time was reset.

The stamps of each input form a line: each continues from the newest one, within limits of delay and
elapsed time. An outlying stamp starts another line, a rival. Its meaning follows from the other
inputs, since a change of all clocks (a bag played in a loop, a system clock that steps) moves them
together, and a wrong stamp does not:

* the line goes on: the rival was a wrong stamp, or several;
* most of the needed inputs, or the node's own clock, moved by the same time as the images: time
  was reset;
* an input's rival fits the images' time, and its line does not: its clock has come right;
* a rival has lasted for `LASTING_S` and nothing came on the line: that is the input's time now.

A rival that is ahead by no more than `AHEAD_NS` leads. It may be right: a network that was
congested from the start recovers, or the clock that stamps all inputs was set. It is trusted if the
images and most of the needed inputs lead equally, or if it outlasts its line, and then nothing is
discarded. Until then it is held, since a wrong stamp may lead, too.

Inputs that positions do not need are treated in the same way, but do not take part in decisions.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from aerial_gnss_ros.core.telemetry.stamp_decision import Decision, Verdict
from aerial_gnss_ros.core.telemetry.stamp_line import EARLY_NS, LATE_NS, Line

SAME_NS = 10_000_000_000
"""Greatest difference between stamps of inputs with the same clock, ns: latency, delays and short
pauses."""

ALIKE_NS = 3_000_000_000
"""Greatest difference between inputs that moved by the same time, ns: delays vary."""

SEVERAL = 3
"""Number of consecutive stamps that are not accidental."""

LASTING_S = 10.0
"""Time after which a rival is the input's time if its line gets no stamps, s."""

DETECTIONS = "detections"


@dataclass
class Stamps:
    """The lines of one input: the trusted one, and its rival, if any."""

    believed: Line
    rival: Line | None = None


@dataclass
class Clock:
    """Decides on the stamps of all inputs.

    Args:
        needed: telemetry on topics that positions need.
        held: inputs whose values are valid until replaced, so that old stamps do not matter.
    """

    needed: Collection[str]
    held: Collection[str] = ()
    _inputs: dict[str, Stamps] = field(default_factory=dict)
    _now_ns: int | None = None
    _stepped_ns: int = 0
    _led: tuple[int | None, int] | None = None
    _heard: list[Line] = field(default_factory=list)  # since the last tick

    def newest(self, name: str) -> int | None:
        """Return the newest trusted stamp of an input, ns."""
        stamps = self._inputs.get(name)
        return None if stamps is None else stamps.believed.newest_ns

    def tick(self, now_ns: int) -> None:
        """Update the node's time, which may step; it is that of the stamps that arrived last."""
        before, self._now_ns = self._now_ns, now_ns
        if before is not None and now_ns < before - EARLY_NS:
            self._stepped_ns = now_ns - before if now_ns < before - LATE_NS else self._stepped_ns
            for stamps in self._inputs.values():
                for line in (stamps.believed, stamps.rival):
                    if line is not None:
                        line.offset_ns, line.told_ns = None, now_ns
        for line in self._heard:
            line.note_arrival(now_ns)
        self._heard.clear()

    def step(self, by_ns: int) -> None:
        """Record a known step of the node's time.

        Args:
            by_ns: size of the step, ns.
        """
        self._stepped_ns = by_ns
        for stamps in self._inputs.values():
            for line in (stamps.believed, stamps.rival):
                if line is not None:
                    line.offset_ns = line.told_ns = None

    def silent(self) -> tuple[str, ...]:
        """Return the inputs whose stamps are ahead only because they were silent, or lead.

        Their leads turn out to be right.
        """
        if all(stamps.rival is None for stamps in self._inputs.values()):
            return ()
        leads = self._leads_alike()
        return tuple(
            name
            for name, stamps in self._inputs.items()
            if name in leads or self._was_silent(stamps)
        )

    def leads(self, name: str) -> bool:
        """Return whether an input has a rival that leads."""
        rival = self._inputs[name].rival
        return rival is not None and rival.leads

    def _was_silent(self, stamps: Stamps) -> bool:
        line, rival = stamps.believed, stamps.rival
        if rival is None or rival.first_ns < line.newest_ns:
            return False
        if line.offset_ns is None and self._stepped_ns > 0:
            return False  # the node's clock was set: it no longer gives the elapsed time
        if not rival.leads:
            return line.offset_ns is None or not line.is_behind(rival.newest_ns, self._now_ns)
        # Only at the time of its arrival: later, no stamp is ahead any more.
        if line.offset_ns is None or not line.is_behind(rival.first_ns, rival.begun_ns):
            return True
        return rival.count > 1 and rival.span_s >= min(LASTING_S, line.span_s)

    def _leads_alike(self) -> Collection[str]:
        """Return the leading inputs, if the images and most of the needed inputs lead."""
        images = self._inputs.get(DETECTIONS)
        leads = {
            name: self._moved_ns(stamps)
            for name, stamps in self._inputs.items()
            if stamps.rival is not None and stamps.rival.leads
        }
        if images is not None and DETECTIONS in leads:
            by_ns = leads[DETECTIONS]
            alike = {name for name, one in leads.items() if abs(one - by_ns) <= EARLY_NS}
            needed = [name for name in self.needed if name in self._inputs]
            if 2 * sum(name in alike for name in needed) >= len(needed):
                self._led = self._now_ns, by_ns
                return alike
        # Others have continued in this way since the last stamp of an input, which is less
        # frequent.
        return {
            name
            for name, one in leads.items()
            if self._led is not None
            and abs(one - self._led[1]) <= EARLY_NS
            and (self._inputs[name].believed.told_ns or 0) <= (self._led[0] or 0)
        }

    def judge(self, name: str, stamp_ns: int) -> Verdict:
        """Judge a stamp of an input."""
        stamps = self._inputs.get(name)
        if stamps is None:
            line = Line(stamp_ns, stamp_ns)
            self._add(line, stamp_ns)
            self._inputs[name] = Stamps(line)
            return Verdict.GOES_ON
        line = stamps.believed
        old = name in self.held and stamp_ns < line.newest_ns
        if old or line.goes_on(stamp_ns, self._now_ns):
            self._add(line, stamp_ns)
            returns, stamps.rival = stamps.rival is not None, None
            return Verdict.RETURNS if returns else Verdict.GOES_ON
        verdict = Verdict.FAR_OFF
        if stamps.rival is None or not stamps.rival.goes_on(stamp_ns, self._now_ns):
            verdict = Verdict.FAR_OFF if stamps.rival is None else Verdict.ELSEWHERE
            stamps.rival = Line(stamp_ns, stamp_ns, leads=line.is_led(stamp_ns, self._now_ns))
        self._add(stamps.rival, stamp_ns)
        return verdict

    def _add(self, line: Line, stamp_ns: int) -> None:
        line.add(stamp_ns)
        if all(one is not line for one in self._heard):
            self._heard.append(line)

    def apart_s(self, name: str) -> float:
        """Return the lead of an input's rival over its line, s."""
        stamps = self._inputs[name]
        return self._moved_ns(stamps) * 1e-9

    def decision(self, name: str) -> Decision | None:
        """Return the decision on outlying stamps after one of an input; None: undecided."""
        images = self._inputs.get(DETECTIONS)
        if name != DETECTIONS:
            came_right = self._came_right(name, images)
            if came_right is not None:
                return came_right
        if images is None or images.rival is None or images.rival.leads:
            return None
        return self._anew(images)

    def believe(self, decision: Decision) -> None:
        """Replace the lines of moved inputs, and after a reset all others except those kept."""
        if decision.time_reset:
            self._stepped_ns = 0
        for name in list(self._inputs):
            if (decision.time_reset and name not in decision.kept) or name in decision.moved:
                del self._inputs[name]

    def goes_on(self, name: str) -> None:
        """Let the next stamp of an input continue its line: it was only silent."""
        stamps = self._inputs[name]
        line, rival = stamps.believed, stamps.rival
        assert rival is not None  # noqa: S101 - `silent` names it
        line.newest_ns, stamps.rival = rival.first_ns, None
        if rival.leads and rival.offset_ns is not None:
            line.offset_ns = max(rival.offset_ns, line.offset_ns or rival.offset_ns)

    def _moved_ns(self, stamps: Stamps) -> int:
        if stamps.rival is None:
            return 0
        rival = stamps.rival.expected_ns(self._now_ns)
        return rival - stamps.believed.expected_ns(self._now_ns)

    def _near(self, one: Line, other: Line) -> bool:
        apart = one.expected_ns(self._now_ns) - other.expected_ns(self._now_ns)
        return abs(apart) <= SAME_NS

    def _came_right(self, name: str, images: Stamps | None) -> Decision | None:
        """Return whether an input's clock alone was set."""
        stamps = self._inputs[name]
        line, rival = stamps.believed, stamps.rival
        if rival is None or rival.leads:
            return None
        several = rival.count >= SEVERAL or rival.count > line.count
        fits = images is None or (
            self._near(rival, images.believed) and not self._near(line, images.believed)
        )
        if rival.span_s >= LASTING_S or (several and fits):
            return Decision(False, (name,))
        return None

    def _anew(self, images: Stamps) -> Decision | None:
        """Return whether time was reset, by most of the inputs with the images' clock."""
        rival = images.rival
        assert rival is not None  # noqa: S101 - asked for only then
        by_ns = self._moved_ns(images)
        stepped = bool(self._stepped_ns) and abs(self._stepped_ns - by_ns) <= ALIKE_NS
        moved, kept, stays = [DETECTIONS], [], 0
        for name, stamps in self._inputs.items():
            if name == DETECTIONS:
                continue
            # Inputs without stamps since the node's clock stepped are no evidence against it.
            counts = name in self.needed and not (stepped and not stamps.believed.heard)
            if stamps.rival is not None:
                if abs(self._moved_ns(stamps) - by_ns) <= ALIKE_NS:
                    moved.append(name)
            elif self._near(stamps.believed, images.believed):
                stays += counts
            elif self._near(stamps.believed, rival):
                kept.append(name)
        witnesses = stepped + sum(name in self.needed for name in (*moved, *kept))
        if witnesses > stays:
            time_reset = stepped or rival.count > 1 or images.believed.count < SEVERAL
        elif stays:
            time_reset = rival.span_s >= LASTING_S
        else:
            time_reset = rival.count > SEVERAL
        if not time_reset:
            return None
        clock = ("clock",) if stepped else ()
        timed = not stepped and images.believed.told_ns is not None
        return Decision(True, (*moved, *clock), tuple(kept), by_ns, rival.first_ns, timed, stepped)
