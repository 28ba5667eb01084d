# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The hypothesis that robots which look moored are moored, beside the law that lets all swim.

A thing that stays makes compass, gimbal and height observable; the law that lets every robot swim
cannot know that. So a second joint law runs beside it, in which robots that seem to stay, or to
drift with one current, do so and the others swim as before (`moored_law`). Both predict each image,
and the sum of the differences of their log likelihoods tells which one the flight bears out
(prequential evidence: Dawid 1984). Association and all tests for faults stay with the first one,
which the second never touches: a wrong hypothesis costs nothing but the time until it is given up.

A robot joins where the current's velocity is likelier than any other (Savage-Dickey ratio). It
leaves when its boxes go away from where it should be, by sums of its innovations over
`TUNING.windows_s`. The mean square of these sums also tells how much the robots swing, or for how
long errors of their boxes last: both add up where white noise would not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.moored_law import CURRENT, MooredLaw, likely_still, most_alike
from aerial_gnss_ros.core.filter.state import JointState, copy_robot
from aerial_gnss_ros.core.filter.update import Outcome, correct
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MooredTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    watched_s: float = 2.0
    """A robot is watched for so long before it may be taken to be moored, s. Judged."""
    asked_every_s: float = 0.5
    """How often it is asked whether further robots are, s. Judged."""
    joins_nats: float = 1.0
    """Log odds from which a robot is taken to be moored, on trial. Judged."""
    first_nats: float = -7.0
    """Log odds of this law to the one in which all swim, before anything is seen: errors that last
    make evidence look larger than it is. Judged."""
    given_up_nats: float = -15.0
    """Log odds below which it is given up, and another one begun. Judged."""
    windows_s: tuple[float, float] = (1.0, 6.0)
    """Time constants over which innovations of a moored robot add up, s. Judged."""
    leaves_squared: float = 18.0
    """Squared sum of innovations, normalised, at which it is as likely to have left as not; the log
    odds grow by half of what is beyond. 1e-4 of the chi-square law of two degrees of freedom; a
    robot that has not left is tried again after a pause."""
    strained: float = 1.25
    """Mean of the first of these squared sums, halved, above which the swing is larger. Judged."""
    slack: float = 0.9
    """Below which it is smaller. Judged."""
    strain_s: float = 2.0
    """Time over which that mean is taken, anew after each change, s. Judged."""
    larger: float = 1.6
    """By what factor the swing's variance then changes. Judged."""
    least_sway_m: float = 0.01
    """Least swing, one sigma, m. Judged."""
    largest_sway_m: float = 0.3
    """Largest swing, one sigma, m. Judged."""
    pause_s: float = 5.0
    """What was wrong is not tried again so soon, s; twice as long each further time. Judged."""
    longest_pause_s: float = 60.0
    """At most so long, s. Judged."""


TUNING = MooredTuning()

_WINDOWS = np.array(TUNING.windows_s)
_NONE = np.array([np.nan, np.nan])


class MooredHypothesis:
    """Of the robots of one joint law.

    Args:
        base: the law that lets all robots swim.
        adrift: whether what does not swim drifts with a current, or stays.

    Attributes:
        base: the same.
        law: the one in which some are moored; None where none is tried.
        evidence: log odds of it to `base`, nats; -inf where none is tried.
        left: probabilities that moored robots have left, by their number in `ids`.
    """

    def __init__(self, base: JointState, adrift: bool) -> None:
        self.base, self.adrift = base, adrift
        self._watched_s: dict[int, float] = {}
        self._barred_s: dict[int, float] = {}
        self._pauses_s: dict[int, float] = {}
        self._pause_s, self._paused_s = TUNING.pause_s, 0.0
        self._since_s = self._step_s = 0.0
        self.reset()

    def reset(self) -> None:
        """Give the hypothesis up."""
        self.law: MooredLaw | None = None
        self.evidence = -math.inf
        self.left: dict[int, float] = {}
        # Of each moored robot, a row a window: sum of its innovations (2), their variance.
        self._sums: dict[int, Array] = {}
        self._strain = np.zeros(2)

    def predict(self, seconds: float, keep: Array, stationary: Array, motion: MotionModel) -> None:
        """Move on in time, before `base` does (see `JointState.predict`)."""
        if seconds <= 0.0:
            return
        self._since_s += seconds
        self._step_s = seconds
        self._paused_s = max(0.0, self._paused_s - seconds)
        ids = self.base.ids.tolist()
        self._watched_s = {one: self._watched_s.get(one, 0.0) + seconds for one in ids}
        self._barred_s = {
            one: left - seconds for one, left in self._barred_s.items() if left > seconds
        }
        if self.law is None:
            return
        self._sync(self.law)
        if len(self._sums) < 1 + self.adrift:
            self.reset()
            return
        self.law.predict(seconds, keep, stationary, motion)
        fades = np.exp(-seconds / _WINDOWS)[:, None]
        for sums in self._sums.values():
            sums[:, :2] *= fades
            sums[:, 2:] *= fades * fades

    def update(
        self, outcome: Outcome, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> None:
        """Take in an image that `base` has taken in already.

        Args:
            outcome: how well the image fitted `base`; its m robots.
            pixels: (m, 2) of their boxes.
            view: the camera.
            model: white noise of pose and boxes.
            level: factor by which that noise is larger than stated.
        """
        if self.law is not None and len(outcome.slots):
            self._sync(self.law)
            place = {one: slot for slot, one in enumerate(self.law.ids.tolist())}
            slots = np.array([place[one] for one in self.base.ids[outcome.slots].tolist()], np.intp)
            try:
                found = correct(self.law, slots, pixels, view, model, np.inf, level)
            except np.linalg.LinAlgError:
                self._fail()
            else:
                self._compare(self.law, found, outcome)
        if self._since_s >= TUNING.asked_every_s and self._paused_s <= 0.0:
            self._since_s = 0.0
            if self.law is not None:
                self._adapt(self.law)
            self._ask()

    def _compare(self, law: MooredLaw, found: Outcome, base: Outcome) -> None:
        """Take in how well an image fitted both laws."""
        if found.count == base.count:
            gained = found.log_likelihood - base.log_likelihood
            self.evidence += gained
        squares: dict[int, float] = {}
        names = law.ids[found.slots].tolist()
        for name, own in zip(names, found.normalised(), strict=True):
            if name in self._sums:
                sums = self._sums[name]
                sums[:, :2] += own
                sums[:, 2] += 1.0
                each = (sums[:, :2] ** 2).sum(axis=1) / sums[:, 2]
                squares[name] = float(each.max())
                self._strain += self._step_s * np.array([0.5 * each[0], 1.0])
        beyond = {name: squared - TUNING.leaves_squared for name, squared in squares.items()}
        self.left |= {name: _share(0.5 * more) for name, more in beyond.items()}
        leaving = [name for name, more in beyond.items() if more > 0.0]
        most = len(leaving) > 1 and 2 * len(leaving) > len(self._sums)
        if most or self.evidence < TUNING.given_up_nats:
            self._fail()
        elif leaving:
            self._release(law, max(leaving, key=lambda name: squares[name]))

    def _fail(self) -> None:
        """Give the hypothesis up, and try no other one for a while."""
        self.reset()
        self._paused_s = self._pause_s
        self._pause_s = min(2.0 * self._pause_s, TUNING.longest_pause_s)

    def _release(self, law: MooredLaw, name: int) -> None:
        """Let a robot swim that has left."""
        del self._sums[name], self.left[name]
        pause = self._pauses_s.get(name, TUNING.pause_s)
        self._barred_s[name] = pause
        self._pauses_s[name] = min(2.0 * pause, TUNING.longest_pause_s)
        law.release(int(np.flatnonzero(law.ids == name)[0]))

    def _ask(self) -> None:
        """Ask which robots that are in view may be moored, or drift as the others do."""
        if self.law is None:
            begin = self._first()
            if not begin:
                return
            self.law = MooredLaw.of(self.base, self.adrift)
            self.evidence = TUNING.first_nats
            for slot in begin:
                self._moor(self.law, slot)
        while True:
            odds = {slot: self.law.odds(slot) for slot in self._eligible(self.law)}
            best = max(odds, key=lambda slot: odds[slot], default=-1)
            if best < 0 or odds[best] < TUNING.joins_nats:
                return
            self._moor(self.law, best)

    def begin_as(self, drifting: MooredHypothesis, least: float) -> None:
        """Begin with what is known where robots drift, now that they may do so by nothing.

        Args:
            drifting: the hypothesis that they drift.
            least: log odds to it from which this one is tried, nats.
        """
        other = drifting.law
        if self.law is not None or other is None or self._paused_s > 0.0:
            return
        odds = other.still_odds()
        if odds > least:
            self.law, self.evidence = other.without_current(), drifting.evidence + odds
            self._sums = {one: sums.copy() for one, sums in drifting._sums.items()}
            self.left = dict(drifting.left)

    def _first(self) -> list[int]:
        """Return the robots of `base` with which the hypothesis begins."""
        asked = self._eligible(self.base)
        if not self.adrift:
            return likely_still(self.base, asked, TUNING.joins_nats)
        one = most_alike(self.base, asked, TUNING.joins_nats)
        return [one] if one >= 0 else []

    def _moor(self, law: MooredLaw, slot: int) -> None:
        law.moor(slot)
        self._sums[int(law.ids[slot])] = np.zeros((len(_WINDOWS), 3))

    def _eligible(self, law: JointState) -> list[int]:
        """Return the robots in view that swim so far and were watched for long enough."""
        return [
            slot
            for slot, one in enumerate(law.ids.tolist())
            if one not in self._sums
            and law.unseen[slot] == 0.0
            and self._watched_s.get(one, 0.0) >= TUNING.watched_s
            and one not in self._barred_s
        ]

    def _adapt(self, law: MooredLaw) -> None:
        """Let the swing be as large as boxes tell."""
        squares, weight = self._strain.tolist()
        if weight < TUNING.strain_s * len(self._sums):
            return
        self._strain[:] = 0.0
        if squares > TUNING.strained * weight:
            law.variance = min(law.variance * TUNING.larger, TUNING.largest_sway_m**2)
        elif squares < TUNING.slack * weight:
            law.variance = max(law.variance / TUNING.larger, TUNING.least_sway_m**2)

    def _sync(self, law: MooredLaw) -> None:
        """Let the law have the robots that the base has."""
        theirs = self.base.ids
        if len(theirs) + 1 != len(law) or not np.isin(theirs, law.ids).all():
            gone = np.flatnonzero(~np.isin(law.ids, theirs) & (law.ids != CURRENT))
            for one in law.ids[gone].tolist():
                self._sums.pop(one, None)
                self.left.pop(one, None)
            law.drop(gone)
            for slot in np.flatnonzero(~np.isin(theirs, law.ids)).tolist():
                added = copy_robot(self.base, slot, law)
                law.ids[added] = theirs[slot]
        own = dict(zip(theirs.tolist(), self.base.own.T, strict=True))
        law.own = np.array([own.get(one, _NONE) for one in law.ids.tolist()]).T


def _share(odds: float) -> float:
    """Return the probability that belongs to log odds."""
    return 1.0 / (1.0 + math.exp(-min(max(odds, -50.0), 50.0)))
