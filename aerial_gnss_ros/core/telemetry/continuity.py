# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether samples can follow one another: what no platform can have done is not believed.

Samples form courses: each sample goes on the course that it can best have come from. Only one
course is believed at a time. A sample that cannot have come from there begins another course or
goes on one, and is refused. Time passing does not make it credible: a place that a course has
stayed at is no nearer to the believed one because the platform could by now have flown there.

Two courses that contradict each other are decided by how long they lasted, since the sensor was
wrong in one of them: the newer one is believed when it has gone on without a break for longer than
the older one had, at least `LEAST_S` and at most `settle_s`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

Place = TypeVar("Place")

LEAST_S = 3.0
"""A course that lasted for less is never believed against another one."""

MOST_STEP_S = 2.5
"""Two samples of a course count for so much of its time at most: silence proves nothing."""

COURSES = 4
"""Courses kept; the one that is longest without a sample goes first."""


@dataclass
class Course(Generic[Place]):
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

    def go_on(self, stamp_ns: int, place: Place, unbroken: bool) -> None:
        """Take in a sample; `unbroken`: the one before it was of this course, too."""
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
        apart: how far it is from the last one that was believed.
        passed_s: time since that one, s.
        believed: whether it is used.
        replaced: whether its course is believed from now on, and another one was until now.
    """

    apart: float
    passed_s: float
    believed: bool
    replaced: bool = False


class Continuity(Generic[Place]):
    """Judges samples by those before them.

    Args:
        distance: between two samples.
        step: by how much a sample may jump at once, in the unit of the distance.
        speed: how fast it may change, per second.
        settle_s: a course that lasted for longer is believed whatever was before, s.
        frozen_s: a value that repeats exactly may have been wrong for so long while the platform
            moved, s.
        must_vary: never believe a new course that repeats one exact value.
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
        self._courses: list[Course[Place]] = []
        self._last: Course[Place] | None = None

    def clear(self) -> None:
        """Forget everything: the next sample is believed."""
        self._courses.clear()
        self._last = None

    @property
    def lasted_s(self) -> float:
        """For how long samples of the believed course came, s."""
        return self._courses[0].lasted_s if self._courses else 0.0

    def take(self, stamp_ns: int, place: Place) -> Verdict:
        """Take in a sample; return whether it is believed."""
        if not self._courses:
            self._last = self._begun(stamp_ns, place)
            return Verdict(0.0, 0.0, True)
        believed = self._courses[0]
        apart = self._distance(believed.place, place)
        passed_s = (stamp_ns - believed.stamp_ns) * 1e-9
        course = self._chosen(stamp_ns, place)
        if self._share(course, stamp_ns, place) > 1.0:
            course = self._begun(stamp_ns, place)
        else:
            course.go_on(stamp_ns, place, unbroken=course is self._last)
        self._last = course
        if course is believed:
            return Verdict(apart, passed_s, True)
        if not self._outlasts(course, believed):
            return Verdict(apart, passed_s, False)
        self._courses.remove(course)
        self._courses.insert(0, course)
        return Verdict(apart, passed_s, True, replaced=True)

    def _chosen(self, stamp_ns: int, place: Place) -> Course[Place]:
        """Return the course that a sample goes on, if it can go on any.

        That is the one which has the least to explain. What lies within a step of the believed
        course, or nearer to it than to the other one, is no evidence for another: the longer a
        course had no samples, the farther it reaches, and noise would turn the scale.
        """
        believed = self._courses[0]
        if self._distance(believed.place, place) <= self._step:
            return believed
        course = min(self._courses, key=lambda one: self._share(one, stamp_ns, place))
        nearer = self._distance(believed.place, place) <= self._distance(course.place, place)
        return believed if nearer and self._share(believed, stamp_ns, place) <= 1.0 else course

    def _share(self, course: Course[Place], stamp_ns: int, place: Place) -> float:
        """Return how much of what is possible a sample would take; above 1 it cannot be."""
        since_s = abs(stamp_ns - course.stamp_ns) * 1e-9 + min(self._frozen_s, course.frozen_s)
        return self._distance(course.place, place) / (self._step + self._speed * since_s)

    def _outlasts(self, course: Course[Place], believed: Course[Place]) -> bool:
        if self._must_vary and not course.varied:
            return False
        return course.lasted_s >= max(LEAST_S, min(believed.lasted_s, self._settle_s))

    def _begun(self, stamp_ns: int, place: Place) -> Course[Place]:
        course = Course(place, stamp_ns, stamp_ns)
        self._courses.append(course)
        if len(self._courses) > COURSES:
            oldest = min(self._courses[1:-1], key=lambda one: one.stamp_ns)
            self._courses = [one for one in self._courses if one is not oldest]
        return course
