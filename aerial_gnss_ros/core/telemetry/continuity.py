# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Continuity of samples: refuses steps that no platform can have made.

Samples form runs: each one extends the run that it most plausibly continues. One run is accepted at
a time; a sample that cannot continue it starts or extends another run and is refused. Elapsed time
does not make it credible: a position at which a run has stayed is no closer to the accepted one
because the platform could have flown there by now.

Of two contradictory runs the sensor was wrong in one. Their duration decides: the newer one is
accepted when it has lasted without a gap for longer than the older one, at least `LEAST_S` and at
most `settle_s`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

Place = TypeVar("Place")

LEAST_S = 3.0
"""Duration below which a run is never accepted against another one, s."""

MOST_STEP_S = 2.5
"""Greatest contribution of one gap between samples to a run's duration, s."""

MAX_RUNS = 4
"""Greatest number of runs; the one longest without a sample is dropped first."""


@dataclass
class SampleRun(Generic[Place]):
    """Samples that can follow one another.

    Attributes:
        place: position of the newest sample.
        stamp_ns: its stamp, ns.
        changed_ns: stamp since which samples repeat exactly, ns.
        lasted_s: duration covered by samples, s.
        varied: whether samples ever differed.
    """

    place: Place
    stamp_ns: int
    changed_ns: int
    lasted_s: float = 0.0
    varied: bool = False

    @property
    def frozen_s(self) -> float:
        """Time for which the value has repeated exactly, s."""
        return (self.stamp_ns - self.changed_ns) * 1e-9

    def extend(self, stamp_ns: int, place: Place, unbroken: bool) -> None:
        """Add a sample; `unbroken`: the previous sample was of this run, too."""
        if stamp_ns <= self.stamp_ns:
            return
        if unbroken:
            self.lasted_s += min(MOST_STEP_S, (stamp_ns - self.stamp_ns) * 1e-9)
        if place != self.place:
            self.changed_ns, self.varied = stamp_ns, True
        self.place, self.stamp_ns = place, stamp_ns


@dataclass(frozen=True)
class Verdict:
    """Decision about a sample.

    Attributes:
        distance: distance from the last accepted sample.
        elapsed_s: time since that one, s.
        accepted: whether it is used.
        replaced: whether its run has just replaced the accepted one.
    """

    distance: float
    elapsed_s: float
    accepted: bool
    replaced: bool = False


def _anywhere(_: object) -> bool:
    return True


class Continuity(Generic[Place]):
    """Tests samples against earlier ones.

    Args:
        distance: between two samples.
        step: greatest instantaneous step, in the unit of the distance.
        speed: greatest rate of change, per second.
        settle_s: duration after which a run is accepted against any other, s.
        frozen_s: time for which a sensor may repeat one value while the platform moves, s.
        must_vary: never accept a new run that repeats one exact value.
        usable: whether a new run may be accepted at a sample.
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
        usable: Callable[[Place], bool] = _anywhere,
    ) -> None:
        self._distance = distance
        self._step = step
        self._speed = speed
        self._settle_s = settle_s
        self._frozen_s = frozen_s
        self._must_vary = must_vary
        self._usable = usable
        self._runs: list[SampleRun[Place]] = []
        self._last: SampleRun[Place] | None = None

    def clear(self) -> None:
        """Forget everything: the next sample is accepted."""
        self._runs.clear()
        self._last = None

    @property
    def lasted_s(self) -> float:
        """Duration of the accepted run, s."""
        return self._runs[0].lasted_s if self._runs else 0.0

    def update(self, stamp_ns: int, place: Place) -> Verdict:
        """Update with a sample; return whether it is accepted."""
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
        """Return the run that a sample continues best.

        A sample within a step of the accepted run, or closer to it than to the other one, is no
        evidence for another run: the longer a run had no samples, the farther it reaches, and noise
        would decide.
        """
        believed = self._runs[0]
        if self._distance(believed.place, place) <= self._step:
            return believed
        run = min(self._runs, key=lambda one: self._share(one, stamp_ns, place))
        nearer = self._distance(believed.place, place) <= self._distance(run.place, place)
        return believed if nearer and self._share(believed, stamp_ns, place) <= 1.0 else run

    def _share(self, run: SampleRun[Place], stamp_ns: int, place: Place) -> float:
        """Return the used share of the possible change; above 1 the sample cannot follow."""
        since_s = abs(stamp_ns - run.stamp_ns) * 1e-9 + min(self._frozen_s, run.frozen_s)
        return self._distance(run.place, place) / (self._step + self._speed * since_s)

    def _outlasts(self, run: SampleRun[Place], believed: SampleRun[Place]) -> bool:
        if (self._must_vary and not run.varied) or not self._usable(run.place):
            return False
        return run.lasted_s >= max(LEAST_S, min(believed.lasted_s, self._settle_s))

    def _start_run(self, stamp_ns: int, place: Place) -> SampleRun[Place]:
        run = SampleRun(place, stamp_ns, stamp_ns)
        self._runs.append(run)
        if len(self._runs) > MAX_RUNS:
            oldest = min(self._runs[1:-1], key=lambda one: one.stamp_ns)
            self._runs = [one for one in self._runs if one is not oldest]
        return run
