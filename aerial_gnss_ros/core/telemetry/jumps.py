# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Jumps of a sensor, and single samples that are wrong: steps that no platform makes.

A sample that no platform can have reached from those before it is held until the next ones. If they
go on where those before it left off, it was wrong alone, and is left out. If they agree with it,
the sensor has jumped: all of them are used, marked with how far it has jumped. Between the samples
before and after it, a position or a height is what it would be without the jump, and there is no
orientation. So only images between the last sample and a conspicuous one wait longer.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import islice
from typing import Generic, TypeVar

from aerial_gnss_ros.core.geometry.frames import wrap_angle
from aerial_gnss_ros.core.geometry.geodesy import metres_per_radian
from aerial_gnss_ros.core.numerics.usual_step import UsualStep
from aerial_gnss_ros.core.telemetry.interpolation import (
    interpolate_fixes,
    interpolate_orientations,
    interpolate_scalars,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

T = TypeVar("T", Fix, Orientation, Scalar)
Step = tuple[float, ...]


@dataclass(frozen=True)
class JumpsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    held_s: float = 0.3
    """Time after which samples that stay away are used, s; two of them at least. Judged."""
    ahead_ratio: float = 2.0
    """How much farther ahead than back samples may be extrapolated. Judged."""
    remembered: int = 256
    """Number of samples by which they are extrapolated at most. Judged."""
    jumps: int = 16
    """Number of jumps that are remembered, back to which it may jump. Judged."""
    usual_m: float = 2.0
    """Usual deviation of a position or height before the first, m. Judged."""
    usual_rad: float = 0.03
    """The same of an orientation, rad. Judged."""
    gust_mps2: float = 10.0
    """Acceleration of a drone, m/s²: that of gravity, at a bank of 45 deg."""
    turn_radps2: float = 5.0
    """Angular acceleration of a drone or a gimbal that does not return at once, rad/s². Judged."""


TUNING = JumpsTuning()


@dataclass(frozen=True)
class Kind(Generic[T]):
    """One kind of value.

    Attributes:
        between: interpolates two samples at a fraction, also beyond 1, and stamps the result.
        step: from one sample to another: East and North, m; an angle, rad; a height, m.
        usual: length of a deviation before the first one.
        acceleration: greatest second derivative.
    """

    between: Callable[[T, T, float, int], T]
    step: Callable[[T, T], Step]
    usual: float
    acceleration: float


class JumpFilter(Generic[T]):
    """Samples of one input, in the order of their stamps.

    Args:
        kind: of its values.

    Attributes:
        left_out: how far off the samples were that the last one has shown to be wrong; else 0.
    """

    def __init__(self, kind: Kind[T]) -> None:
        self._kind: Kind[T] = kind
        self._past: deque[T] = deque(maxlen=TUNING.remembered)
        self._held: list[T] = []
        self.clear()

    def clear(self) -> list[T]:
        """Forget all samples and jumps; return the samples held, which nothing will judge."""
        held = self.interrupt()
        self._usual = UsualStep(self._kind.usual)
        self._jumps: deque[Step] = deque([()], maxlen=TUNING.jumps)
        return held

    def interrupt(self) -> list[T]:
        """Extrapolate no sample from earlier ones; return those held, as `update` would."""
        held, self._held = self._held, []
        self._past.clear()
        self.left_out = 0.0
        return [self._marked(one) for one in held]

    def update(self, value: T) -> list[T]:
        """Return which samples can be used now; empty while the last one is held.

        Args:
            value: a usable sample; one no newer than the last is used as it is.
        """
        past, held = self._past, self._held
        self.left_out = 0.0
        newest = held[-1] if held else past[-1] if past else None
        if newest is not None and value.stamp_ns <= newest.stamp_ns:
            return [self._marked(value)]
        off, allowed = self._deviation(value)
        if not off:  # nothing before it tells where it should be, nor of those held
            usable = self.interrupt() if held else []
            past.append(value)
            usable.append(self._marked(value))
            return usable
        length = math.hypot(*off)
        away = math.hypot(*self._deviation(held[0])[0]) if held else 0.0
        if length > 0.5 * away if held else self._usual.is_odd(length, allowed):
            held.append(value)
            waits = value.stamp_ns - held[0].stamp_ns < TUNING.held_s * 1e9
            return [] if waits else self._jumped(held)
        if held:
            self.left_out, self._held = away, []
        else:
            self._usual.update(length, (value.stamp_ns - past[-1].stamp_ns) * 1e-9)
        past.append(value)
        return [self._marked(value)]

    def _jumped(self, held: list[T]) -> list[T]:
        """Return samples that agree after a jump, marked with it."""
        off, allowed = self._deviation(held[0])
        now = self._jumps[-1] or (0.0,) * len(off)
        there = tuple(a + b for a, b in zip(now, off, strict=True))
        # Back where it was before an earlier jump: noise must not add up.
        back = [
            one
            for one in self._jumps
            if not self._usual.is_odd(math.dist(one or (0.0,) * len(off), there), allowed)
        ]
        self._jumps.append(back[0] if back else there)
        self._past.clear()
        self._past.extend(held)
        self._held = []
        return [self._marked(one) for one in held]

    def _marked(self, value: T) -> T:
        """Return a sample with how far the sensor has jumped."""
        jumped = self._jumps[-1]
        return replace(value, jumped=jumped) if jumped else value

    def _deviation(self, value: T) -> tuple[Step, float]:
        """Return how far a sample is from where those before it lead, and how far a platform gets.

        Empty and 0 where it is too far ahead of them.
        """
        past = self._past
        if len(past) < 2:
            return (), 0.0
        last = past[-1]
        ahead = (value.stamp_ns - last.stamp_ns) * 1e-9
        # The latest one that is far enough back: a drone keeps its velocity for a short time only.
        back = 0.0
        for before in islice(reversed(past), 1, None):
            back = (last.stamp_ns - before.stamp_ns) * 1e-9
            if back >= ahead:
                break
        if ahead > TUNING.ahead_ratio * back:
            return (), 0.0
        there = self._kind.between(before, last, 1.0 + ahead / back, value.stamp_ns)
        step = self._kind.step(there, value)
        return step, 0.5 * self._kind.acceleration * ahead * (ahead + back)


def without_jump(value: T) -> T:
    """Return a sample as if its sensor had not jumped."""
    return replace(value, jumped=()) if value.jumped else value


def fix_jumps() -> JumpFilter[Fix]:
    """Return a filter of the drone's positions."""
    return JumpFilter(Kind(interpolate_fixes, fix_step, TUNING.usual_m, TUNING.gust_mps2))


def orientation_jumps() -> JumpFilter[Orientation]:
    """Return a filter of orientations."""
    kind = Kind(interpolate_orientations, angle_step, TUNING.usual_rad, TUNING.turn_radps2)
    return JumpFilter(kind)


def scalar_jumps() -> JumpFilter[Scalar]:
    """Return a filter of heights."""
    return JumpFilter(Kind(interpolate_scalars, scalar_step, TUNING.usual_m, TUNING.gust_mps2))


def fix_step(one: Fix, other: Fix) -> Step:
    """Return the way from one position to another, East and North, m."""
    east, north = metres_per_radian(one.latitude)
    turn = float(wrap_angle(other.longitude - one.longitude))
    return east * turn, north * (other.latitude - one.latitude)


def angle_step(one: Orientation, other: Orientation) -> Step:
    """Return the angle between two orientations, rad; 0 where their references differ."""
    if one.reference != other.reference:
        return (0.0,)
    p, q = one.quaternion, other.quaternion
    chord = min(math.dist(p, q), math.dist(p, -q))
    return (4.0 * math.asin(min(0.5 * chord, 1.0)),)


def scalar_step(one: Scalar, other: Scalar) -> Step:
    """Return the difference of two heights, m."""
    return (other.value - one.value,)
