# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which stamps to believe, and whether time began anew.

The stamps of each input form a line: they go on from the newest one, as far as they may be late or
time has passed. A stamp far off the line begins another one, a rival. What it means shows in the
other inputs, since whoever sets all clocks (a bag that is played in a loop, a system clock that
steps) moves them alike, and whoever sets one wrong does not:

* the line goes on: the rival was a wrong stamp, or several;
* most of the needed inputs, or the node's own clock, moved by the same time as the images: time
  began anew;
* an input's rival fits the images' time, and its line does not: its clock has come right;
* a rival has lasted for `LASTING_S` and nothing came on the line: that is the input's time now.

A rival that is ahead by no more than `AHEAD_NS` leads. That may be right: a network that was
congested from the start recovers, or the clock was set that stamps all inputs. It is believed where
the images and most of the needed inputs lead alike, or where it outlasts its line, and then nothing
is forgotten. Until then it is held, since a wrong stamp leads just so.

Inputs that no position needs are judged likewise, and decide nothing.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from aerial_gnss_ros.core.telemetry.stamp_decision import Decision, Verdict
from aerial_gnss_ros.core.telemetry.stamp_line import EARLY_NS, LATE_NS, Line

SAME_NS = 10_000_000_000
"""Stamps of inputs with the same clock differ by less: latency, delays and short pauses."""

ALIKE_NS = 3_000_000_000
"""Inputs that moved by the same time differ by less: both have delays that vary."""

SEVERAL = 3
"""So many stamps in a row are no accident."""

LASTING_S = 10.0
"""A rival that lasts for so long, while nothing comes on the line, is the input's time."""

DETECTIONS = "detections"


@dataclass
class Stamps:
    """The lines of one input: the one that is believed, and its rival, where there is one."""

    believed: Line
    rival: Line | None = None


@dataclass
class Clock:
    """Judges the stamps of all inputs.

    Args:
        needed: telemetry that comes on topics and that a position needs.
        held: inputs whose values hold until replaced: stamps of long ago are no matter there.
    """

    needed: Collection[str]
    held: Collection[str] = ()
    _inputs: dict[str, Stamps] = field(default_factory=dict)
    _now_ns: int | None = None
    _stepped_ns: int = 0
    _led: tuple[int | None, int] | None = None
    _heard: list[Line] = field(default_factory=list)  # since the last tick

    def newest(self, name: str) -> int | None:
        """Return the newest believed stamp of an input, ns."""
        stamps = self._inputs.get(name)
        return None if stamps is None else stamps.believed.newest_ns

    def tick(self, now_ns: int) -> None:
        """Take in the node's time, which may step; it is that of the stamps that came last."""
        before, self._now_ns = self._now_ns, now_ns
        if before is not None and now_ns < before - EARLY_NS:
            self._stepped_ns = now_ns - before if now_ns < before - LATE_NS else self._stepped_ns
            for stamps in self._inputs.values():
                for line in (stamps.believed, stamps.rival):
                    if line is not None:
                        line.offset_ns, line.told_ns = None, now_ns
        for line in self._heard:
            line.tell(now_ns)
        self._heard.clear()

    def step(self, by_ns: int) -> None:
        """Take in that the node's time was set just now, by something that knows.

        Args:
            by_ns: by how much, ns.
        """
        self._stepped_ns = by_ns
        for stamps in self._inputs.values():
            for line in (stamps.believed, stamps.rival):
                if line is not None:
                    line.offset_ns = line.told_ns = None

    def silent(self) -> tuple[str, ...]:
        """Return the inputs that were only silent for as long as their stamps are ahead, or lead.

        Theirs are leads that turn out to be right.
        """
        if all(stamps.rival is None for stamps in self._inputs.values()):
            return ()
        leads = self._leads_alike()
        return tuple(
            name
            for name, stamps in self._inputs.items()
            if name in leads or self._was_silent(stamps)
        )

    def _was_silent(self, stamps: Stamps) -> bool:
        line, rival = stamps.believed, stamps.rival
        if rival is None or rival.first_ns < line.newest_ns:
            return False
        if line.offset_ns is None and self._stepped_ns > 0:
            return False  # the node's clock was set: it tells no longer what time has passed
        if not rival.leads:
            return line.offset_ns is None or not line.is_behind(rival.newest_ns, self._now_ns)
        # Only at the time of its arrival: later any stamp that was ahead is ahead no more.
        if line.offset_ns is None or not line.is_behind(rival.first_ns, rival.begun_ns):
            return True
        return rival.count > 1 and rival.span_s >= min(LASTING_S, line.span_s)

    def _leads_alike(self) -> Collection[str]:
        """Return the inputs that lead, where the images and most of the needed inputs do."""
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
        # Others went on so since an input's last stamp, which comes more seldom.
        return {
            name
            for name, one in leads.items()
            if self._led is not None
            and abs(one - self._led[1]) <= EARLY_NS
            and (self._inputs[name].believed.told_ns or 0) <= (self._led[0] or 0)
        }

    def take(self, name: str, stamp_ns: int) -> Verdict:
        """Take in a stamp of an input."""
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
        """Return by how much an input's rival is ahead of its line, s."""
        stamps = self._inputs[name]
        return self._moved_ns(stamps) * 1e-9

    def decision(self, name: str) -> Decision | None:
        """Return what far-off stamps are, after one of an input came; None: not known yet."""
        images = self._inputs.get(DETECTIONS)
        if name != DETECTIONS:
            came_right = self._came_right(name, images)
            if came_right is not None:
                return came_right
        if images is None or images.rival is None or images.rival.leads:
            return None
        return self._anew(images)

    def believe(self, decision: Decision) -> None:
        """Forget the lines of what moved, and all others but those kept where time began anew."""
        if decision.anew:
            self._stepped_ns = 0
        for name in list(self._inputs):
            if (decision.anew and name not in decision.kept) or name in decision.moved:
                del self._inputs[name]

    def goes_on(self, name: str) -> None:
        """Let the next stamp of an input go on from its line: it only was silent."""
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
        """Return whether time began anew, by most of the inputs with the images' clock."""
        rival = images.rival
        assert rival is not None  # noqa: S101 - asked for only then
        by_ns = self._moved_ns(images)
        stepped = bool(self._stepped_ns) and abs(self._stepped_ns - by_ns) <= ALIKE_NS
        moved, kept, stays = [DETECTIONS], [], 0
        for name, stamps in self._inputs.items():
            if name == DETECTIONS:
                continue
            # What has not come since the node's clock stepped along does not speak against it.
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
            anew = stepped or rival.count > 1 or images.believed.count < SEVERAL
        elif stays:
            anew = rival.span_s >= LASTING_S
        else:
            anew = rival.count > SEVERAL
        if not anew:
            return None
        clock = ("clock",) if stepped else ()
        timed = not stepped and images.believed.told_ns is not None
        return Decision(True, (*moved, *clock), tuple(kept), by_ns, rival.first_ns, timed, stepped)
