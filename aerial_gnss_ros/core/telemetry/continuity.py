# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether samples can follow one another: what no platform can have done is not believed.

Samples form runs: each sample goes on the run that it can best have come from. Only one
run is believed at a time. A sample that cannot have come from there begins another run or
goes on one, and is refused. Time passing does not make it credible: a place that a run has
stayed at is no nearer to the believed one because the platform could by now have flown there.

Two runs that contradict each other are decided by how long they lasted, since the sensor was
wrong in one of them: the newer one is believed when it has gone on without a break for longer than
the older one had, at least `LEAST_S` and at most `settle_s`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

Place = TypeVar("Place")

LEAST_S = 3.0
"""A run that lasted for less is never believed against another one."""

MOST_STEP_S = 2.5
"""Two samples of a run count for so much of its time at most: silence proves nothing."""

MAX_RUNS = 4
"""Runs kept; the one that is longest without a sample goes first."""


@dataclass
class SampleRun(Generic[Place]):
    """Samples that can have followed one another.

    Attributes:
        place: the newest one.
        stamp_ns: its stamp, ns.
        changed_ns: since when samples have been exactly the same, ns.
        lasted_s: for how long there were samples, s.
        varied: whether they ever differed.
    """

    place: Place
    stamp_ns: int
    changed_ns: int
    lasted_s: float = 0.0
    varied: bool = False

    @property
    def frozen_s(self) -> float:
        """For how long its value has repeated exactly, s."""
        return (self.stamp_ns - self.changed_ns) * 1e-9

    def extend(self, stamp_ns: int, place: Place, unbroken: bool) -> None:
        """Take in a sample; `unbroken`: the one before it was of this run, too."""
        if stamp_ns <= self.stamp_ns:
            return
        if unbroken:
            self.lasted_s += min(MOST_STEP_S, (stamp_ns - self.stamp_ns) * 1e-9)
        if place != self.place:
            self.changed_ns, self.varied = stamp_ns, True
        self.place, self.stamp_ns = place, stamp_ns


@dataclass(frozen=True)
class Verdict:
    """What became of a sample.

    Attributes:
        distance: how far it is from the last one that was believed.
        elapsed_s: time since that one, s.
        accepted: whether it is used.
        replaced: whether its run is believed from now on, and another one was until now.
    """

    distance: float
    elapsed_s: float
    accepted: bool
    replaced: bool = False


class Continuity(Generic[Place]):
    """Judges samples by those before them.

    Args:
        distance: between two samples.
        step: by how much a sample may jump at once, in the unit of the distance.
        speed: how fast it may change, per second.
        settle_s: a run that lasted for longer is believed whatever was before, s.
        frozen_s: a value that repeats exactly may have been wrong for so long while the platform
            moved, s.
        must_vary: never believe a new run that repeats one exact value.
    """

    def __init__(
        self,
        distance: Callable[[Place, Place], float],
        step: float,
        speed: float,
        settle_s: float,
        *,
        frozen_s: float = 0.0,
        must_vary: bool = False,
    ) -> None:
        self._distance = distance
        self._step = step
        self._speed = speed
        self._settle_s = settle_s
        self._frozen_s = frozen_s
        self._must_vary = must_vary
        self._runs: list[SampleRun[Place]] = []
        self._last: SampleRun[Place] | None = None

    def clear(self) -> None:
        """Forget everything: the next sample is believed."""
        self._runs.clear()
        self._last = None

    @property
    def lasted_s(self) -> float:
        """For how long samples of the believed run came, s."""
        return self._runs[0].lasted_s if self._runs else 0.0

    def update(self, stamp_ns: int, place: Place) -> Verdict:
        """Take in a sample; return whether it is believed."""
        if not self._runs:
            self._last = self._start_run(stamp_ns, place)
            return Verdict(0.0, 0.0, True)
        believed = self._runs[0]
        apart = self._distance(believed.place, place)
        passed_s = (stamp_ns - believed.stamp_ns) * 1e-9
        run = self._matching_run(stamp_ns, place)
        if self._share(run, stamp_ns, place) > 1.0:
            run = self._start_run(stamp_ns, place)
        else:
            run.extend(stamp_ns, place, unbroken=run is self._last)
        self._last = run
        if run is believed:
            return Verdict(apart, passed_s, True)
        if not self._outlasts(run, believed):
            return Verdict(apart, passed_s, False)
        self._runs.remove(run)
        self._runs.insert(0, run)
        return Verdict(apart, passed_s, True, replaced=True)

    def _matching_run(self, stamp_ns: int, place: Place) -> SampleRun[Place]:
        """Return the run that a sample goes on, if it can go on any.

        That is the one which has the least to explain. What lies within a step of the believed
        run, or nearer to it than to the other one, is no evidence for another: the longer a
        run had no samples, the farther it reaches, and noise would turn the scale.
        """
        believed = self._runs[0]
        if self._distance(believed.place, place) <= self._step:
            return believed
        run = min(self._runs, key=lambda one: self._share(one, stamp_ns, place))
        nearer = self._distance(believed.place, place) <= self._distance(run.place, place)
        return believed if nearer and self._share(believed, stamp_ns, place) <= 1.0 else run

    def _share(self, run: SampleRun[Place], stamp_ns: int, place: Place) -> float:
        """Return how much of what is possible a sample would take; above 1 it cannot be."""
        since_s = abs(stamp_ns - run.stamp_ns) * 1e-9 + min(self._frozen_s, run.frozen_s)
        return self._distance(run.place, place) / (self._step + self._speed * since_s)

    def _outlasts(self, run: SampleRun[Place], believed: SampleRun[Place]) -> bool:
        if self._must_vary and not run.varied:
            return False
        return run.lasted_s >= max(LEAST_S, min(believed.lasted_s, self._settle_s))

    def _start_run(self, stamp_ns: int, place: Place) -> SampleRun[Place]:
        run = SampleRun(place, stamp_ns, stamp_ns)
        self._runs.append(run)
        if len(self._runs) > MAX_RUNS:
            oldest = min(self._runs[1:-1], key=lambda one: one.stamp_ns)
            self._runs = [one for one in self._runs if one is not oldest]
        return run
