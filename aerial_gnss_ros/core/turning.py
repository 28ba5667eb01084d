# SPDX-License-Identifier: Apache-2.0
"""Whether the camera turns by itself: a gimbal that runs away, or telemetry that does.

Then all robots in view seem to begin to move at once, each as the turn w of the camera carries the
place under its box: by -A w, A the derivative of places by the platform's angles. As long as that
is slower than robots are, no single image tells it from robots that swim. What tells is the
beginning: robots that change their velocities each by itself do not by chance all do it as one
turn would have it. If all is as stated, the corrections of a robot's velocity over some seconds
have a sum of known covariance (see `manoeuvres`; those by which a velocity was loosened, since
boxes did not fit, are no allowance here). Two explanations of the sums are weighed, in nats:

    robots    sum over robots of the cheaper of: as stated; a swerve (`SWERVE`, `SELDOM`)
    a turn    the same of what the best turn w leaves, its prior and how finely it must be chosen

A fleet that sets out in formation looks the same. So nothing is decided: the filter goes on with
robots that swim, and what would be wrong if it is the camera is published beside its covariance:
of a robot in sight A W A', W = (w t)(w t)' after a time t and what is not known of w t. It is kept
out of the filter, since the turn goes on as no drift of its model does: it would learn what is not
so. When robots all seem to go back, so does the angle.

Boxes that no robots explain (too fast, or elsewhere) do not move the robots. But those that are
found again, or anew, may be seen by a camera that has turned meanwhile: W grows all the same.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

OVER_S = 3.0
"""Time constant with which corrections add up, s."""

EVERY_S = 0.5
"""How often it is judged, s."""

SWERVE = 0.25
"""Change of velocity within seconds, one sigma of each axis, of a robot that swerves, as a share of
the fastest speed."""

SELDOM = 0.25
"""Share of the time in which a robot swerves: of those that steer."""

TURN = math.radians(5.0)
"""One sigma of the rate of a camera that turns by itself, each axis, rad/s."""

BEGINS = 4.0
"""Nats by which a turn must be the likelier explanation to be thought of."""

ENDS = 1.0
"""The same for a change of a turn that is thought of already."""

LOOKED_S = 2.0
"""How long it takes until a turn shows in the velocities, s."""

REFINED_S = 3.0
"""How long a turn that began is made out better, s."""

SIGMAS = 3.0
"""A turn slower than so many sigmas has ended."""

SHARE = 0.3
"""Share of an angle that a turn has run through, one sigma, by which it may be another one."""

LOST = math.radians(20.0)
"""One sigma of the rate at which a camera turns whose boxes no robots explain, each axis, rad/s."""

ALREADY_S = 0.3
"""For so long it has turned when that is noticed, s."""

MOST = math.radians(30.0)
"""Angle, one sigma, up to which doubt grows: nothing is known by then."""


class Turning:
    """Of the robots and the camera of one joint law.

    Attributes:
        rate: (3,) of the turn that is thought of, rad/s, about the axes of roll, pitch, heading;
            0 without one.
        angle: (3,) by which it may have turned so far, rad.
        of_places: (n, 2, 2) by how much more the places of robots are uncertain, m².
        of_velocities: (n, 2, 2) likewise, m²/s².
    """

    def __init__(self) -> None:
        self.rate: Array = np.zeros(3)
        self.angle: Array = np.zeros(3)
        self.of_places: Array = np.zeros((0, 2, 2))
        self.of_velocities: Array = np.zeros((0, 2, 2))
        self._spread: Array = np.zeros((3, 3))
        self._besides: Array = np.zeros((3, 3))
        self._doubted = False  # whether there ever was a doubt
        self._before_lost = self._besides
        self._lasts = self._since = self._lost = self._lost_grown = 0.0
        # Rows: sum of corrections east, north; its expected square; allowance not yet used up.
        self._sums: Array = np.zeros((4, 0))

    @property
    def turns(self) -> bool:
        """Whether a turn is thought of."""
        return bool(self.rate.any())

    @property
    def doubt(self) -> Array:
        """(3, 3) covariance W of the angles, rad²."""
        return np.outer(self.angle, self.angle) + self._besides

    @property
    def sigma(self) -> float:
        """Angle by which it may have turned, one sigma, rad."""
        return math.sqrt(np.trace(self.doubt)) if self._doubted else 0.0

    @property
    def due(self) -> bool:
        """Whether an image's robots are to be judged."""
        return self._since >= EVERY_S or self._doubted

    @property
    def doubts(self) -> bool:
        """Whether any robot is more uncertain for it."""
        return self._doubted and bool(self.of_places.any())

    def add(self, count: int) -> None:
        """Take in robots after the present ones."""
        self._sums = np.concatenate([self._sums, np.zeros((4, count))], axis=1)
        more = np.zeros((count, 2, 2))
        self.of_places = np.concatenate([self.of_places, more])
        self.of_velocities = np.concatenate([self.of_velocities, more])

    def drop(self, kept: NDArray[np.bool_]) -> None:
        """Forget those that are not kept (n,)."""
        self._sums = self._sums[:, kept]
        self.of_places, self.of_velocities = self.of_places[kept], self.of_velocities[kept]

    def inherit(self, old: int, new: int, change: Array, unknown: float) -> None:
        """Let robot `new` go on as `old`, which it turned out to be after a moment.

        Args:
            old: its place.
            new: likewise.
            change: (2,) of the velocity from the one to the other, m/s.
            unknown: variance of its velocity, both axes, m²/s².
        """
        self._sums[:2, new] = self._sums[:2, old] + change
        self._sums[2:, new] = self._sums[2, old], unknown

    def loosened(self, slots: Indices | slice, variance: Array | float) -> None:
        """Take in by how much each axis of some robots' velocities was made uncertain, m²/s²."""
        self._sums[3, slots] += 2.0 * variance

    def note(self, slots: Indices, changes: Array, expected: Array) -> None:
        """Take in an image's corrections.

        Args:
            slots: (m,) the robots.
            changes: (m, 2) of their velocities, m/s.
            expected: (m,) mean squares of these, m²/s².
        """
        allowed = np.minimum(expected, self._sums[3, slots])
        self._sums[:2, slots] += changes.T
        self._sums[2, slots] += expected - allowed
        self._sums[3, slots] -= allowed

    def predict(self, seconds: float, keep: float) -> None:
        """Move on in time.

        Args:
            seconds: length of the step, s.
            keep: factor by which the angles' errors still count after it.
        """
        self._since += seconds
        fade = math.exp(-seconds / OVER_S)
        self._sums[:2] *= fade
        self._sums[2] *= fade * fade
        if not self._doubted:
            return
        self.angle *= keep
        self._besides *= keep * keep
        if self.turns:
            self._grow(self._lasts, self._lasts + seconds)

    def lost(self, seconds: float, over: bool = False) -> None:
        """Take in that for so long no robots explained the boxes, s; 0: some do.

        Args:
            seconds: time since the last image, s.
            over: whether these are robots that were seen before, where they should be.
        """
        if seconds:
            if not self._lost:  # one image may be in error
                self._before_lost = self._besides.copy()
                self._lost = ALREADY_S + seconds
                return
            self._lost += seconds
            before, self._lost_grown = self._lost_grown, min(self._lost, MOST / LOST)
            grown = self._lost_grown**2 - before**2
            self._doubted = True
            self._besides += LOST**2 * grown * np.eye(3)
        elif self._lost:
            self._lost = self._lost_grown = 0.0
            if over:
                self._besides = self._before_lost

    def judge(self, slots: Indices, by_angles: Array, fastest: float) -> None:
        """Judge the robots of an image, where it is due.

        Args:
            slots: (n,) the robots.
            by_angles: (n, 2, 3) how their places move with the platform's angles, m/rad.
            fastest: speed of a robot, m/s.
        """
        if self._since >= EVERY_S:
            self._since = 0.0
            self._weigh(slots, by_angles, fastest)
        across = by_angles.swapaxes(1, 2)
        rates = np.outer(self.rate, self.rate) + self._spread
        self.of_places[slots] = by_angles @ self.doubt @ across
        self.of_velocities[slots] = by_angles @ rates @ across

    def _weigh(self, slots: Indices, by_angles: Array, fastest: float) -> None:
        sums, variances = self._sums[:2, slots].T, 0.5 * self._sums[2, slots]
        change, spread, gain = explained(sums, variances, by_angles, SWERVE * fastest)
        refines = self.turns and self._lasts < LOOKED_S + REFINED_S
        if not refines and gain < (ENDS if self.turns else BEGINS):
            return
        begins = not self.turns
        self._sums[:2, slots] += (by_angles @ change).T
        self.rate = self.rate + change
        self._spread = spread if begins else self._spread + spread
        if self.rate @ np.linalg.solve(self._spread, self.rate) < SIGMAS**2:
            self.rate, self._spread, self._lasts = np.zeros(3), np.zeros((3, 3)), 0.0
        elif begins:
            self._grow(0.0, LOOKED_S)

    def _grow(self, before: float, now: float) -> None:
        """Let doubt grow as a turn goes on from one time to another, s since its beginning."""
        self._lasts, self._doubted = now, True
        angle = self.angle + (now - before) * self.rate
        self.angle = angle * min(1.0, MOST / max(float(np.linalg.norm(angle)), 1e-9))
        most = MOST / float(np.linalg.norm(self.rate))
        squares = min(now, most) ** 2 - min(before, most) ** 2
        self._besides += squares * (SHARE**2 * np.outer(self.rate, self.rate) + self._spread)


def explained(
    sums: Array, variances: Array, by_angles: Array, swerve: float
) -> tuple[Array, Array, float]:
    """Return the turn (3,) that explains changes of velocity best, and by how much better (nats).

    Args:
        sums: (n, 2) changes of velocity, m/s.
        variances: (n,) of each axis by what is stated, m²/s².
        by_angles: (n, 2, 3) m/rad.
        swerve: one sigma of each axis of a swerve, m/s.

    Returns:
        The turn, rad/s; its covariance (3, 3); logarithm of the odds that there is a turn, with
        equal odds before.
    """
    stated = np.maximum(variances, 1e-8)
    wide = stated + swerve**2
    dear = np.log(wide / stated) - math.log(SELDOM)

    def costs(rest: Array) -> tuple[Array, NDArray[np.bool_]]:
        squared = 0.5 * np.einsum("ij,ij->i", rest, rest)
        one, other = squared / stated, squared / wide + dear
        return np.minimum(one, other), other < one

    def fitted(weight: Array) -> tuple[Array, Array]:
        weighted = by_angles * weight[:, None, None]
        information = np.einsum("nik,nil->kl", weighted, by_angles) + np.eye(3) / TURN**2
        told = -np.einsum("nik,ni->k", weighted, sums)
        return np.linalg.solve(information, told), information

    robots = float(costs(sums)[0].sum())
    turn, information = fitted(1.0 / stated)
    for _ in range(3):  # robots that swerve beside count less
        swerves = costs(sums + by_angles @ turn)[1]
        turn, information = fitted(1.0 / np.where(swerves, wide, stated))
    left = float(costs(sums + by_angles @ turn)[0].sum()) + 0.5 * float(turn @ turn) / TURN**2
    finely = 0.5 * float(np.linalg.slogdet(information * TURN**2)[1])
    spread: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return turn, spread, robots - left - finely
