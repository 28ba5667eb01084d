# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The hypothesis that robots which look moored are moored, beside the law that lets all swim.

A thing that stays makes compass, gimbal and height observable; the law that lets every robot swim
cannot know that. So a second joint law runs beside it, in which robots that seem to stay, or to
drift with one current, do so and the others swim as before (`moored_law`). Both predict each image,
and the sum of the differences of their log likelihoods tells which one the flight bears out
(prequential evidence: Dawid 1984). Association and all tests for faults stay with the first one,
which the second never touches: a wrong hypothesis costs nothing but the time until it is given up.

A robot joins where the current's velocity is likelier than any other (Savage-Dickey ratio), and may
cast off at any time (`casting_off`). Its box is judged given all others of the image, so that what
turns the camera tells nothing of it, and the law's evidence counts it by the mixture of both modes:
one robot that leaves is no evidence against what the others do.

A robot that no image has shown for a while is found again where each law expects it, or elsewhere:
that counts as its boxes do, and what is moored stays so.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.casting_off import CastingOff
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.moored_candidates import likely_still, most_alike
from aerial_gnss_ros.core.filter.moored_law import MooredLaw
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.swing import Swing
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel
from aerial_gnss_ros.core.numerics.gaussian import inverse, mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MooredTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    watched_s: float = 2.0
    """A robot is watched for so long before it may be taken to be moored, s. Judged."""
    asked_every_s: float = 0.5
    """How often it is asked whether further robots are, s. Judged."""
    least_robots: int = 2
    """With fewer no law is tried: the drift of a single one may be an error of the platform."""
    joins_nats: float = 1.0
    """Log odds from which a robot is taken to be moored, on trial. Judged."""
    first_nats: float = -7.0
    """Log odds of this law to the one in which all swim, before anything is seen: errors that last
    make evidence look larger than it is. Judged."""
    given_up_nats: float = -15.0
    """Log odds below which it is given up, and another one begun. Judged."""


TUNING = MooredTuning()

_NOBODY = np.zeros(0, np.intp)


class MooredHypothesis:
    """Of the robots of one joint law.

    Args:
        base: the law that lets all robots swim.
        adrift: whether what does not swim drifts with a current, or stays.

    Attributes:
        base: the same.
        law: the one in which some are moored; None where none is tried.
        evidence: log odds of it to `base`, nats; -inf where none is tried.
        leaving: whether moored robots of the law have cast off.
        swing: how much they swing.
    """

    def __init__(self, base: JointState, adrift: bool) -> None:
        self.base, self.adrift = base, adrift
        self._now_s = self._asked_s = self._step_s = 0.0
        self._first_seen_s: dict[int, float] = {}
        self._noted = _NOBODY
        self.reset()

    def reset(self) -> None:
        """Give the hypothesis up."""
        self.law: MooredLaw | None = None
        self.evidence = -math.inf
        self.leaving, self.swing = CastingOff(0), Swing(0)
        # Numbers of the base's and the law's robots, where the law has the base's, and the numbers
        # when it last had all of them.
        self._places = _NOBODY, _NOBODY, _NOBODY
        self._synced = _NOBODY, _NOBODY

    def predict(self, seconds: float, keep: Array, stationary: Array, motion: MotionModel) -> None:
        """Move on in time, before `base` does (see `JointState.predict`)."""
        if seconds <= 0.0:
            return
        if self.base.ids is not self._noted:
            self._noted = self.base.ids
            known = self._first_seen_s
            self._first_seen_s = {one: known.get(one, self._now_s) for one in self._noted.tolist()}
        self._now_s += seconds
        self._step_s = seconds
        if self.law is None:
            return
        self._sync(self.law)
        if self._stay(self.law) < TUNING.least_robots:
            self.reset()
            return
        self._move(self.law, seconds, keep, stationary, motion)
        self.swing.predict(seconds)
        self.leaving.predict(seconds, float(motion.acceleration) ** 2)

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
            slots = self.places()[outcome.slots]
            before = self.law.own_covariances(slots)
            try:
                found = self.law.fit(slots, pixels, view, model, level)
            except np.linalg.LinAlgError:
                self.reset()
            else:
                self._compare(self.law, found, outcome, before)
        if self._now_s - self._asked_s >= TUNING.asked_every_s:
            self._asked_s = self._now_s
            if self.law is not None:
                self.law.variance = self.swing.adapted(self.law.variance, self._stay(self.law))
            self._ask()

    def correct_alone(
        self, slots: Indices, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> None:
        """Correct what `base` has corrected alone (see `update.correct`)."""
        if self.law is None:
            return
        self._sync(self.law)
        try:
            correct(self.law, self.places()[slots], pixels, view, model, level=level, alone=True)
        except np.linalg.LinAlgError:
            self.reset()

    @property
    def odds(self) -> float:
        """Log odds to `base` where slow currents are no less likely than fast ones, nats."""
        slow = self.law.slow_odds() if self.adrift and self.law is not None else 0.0
        return self.evidence + slow

    def places(self) -> Indices:
        """Return where the law has the robots of `base`, (n,); -1: it has not."""
        law, theirs = self.law, self.base.ids
        assert law is not None  # noqa: S101 - asked for only while it is tried
        if self._places[0] is not theirs or self._places[1] is not law.ids:
            place = {one: slot for slot, one in enumerate(law.ids.tolist())}
            found = np.array([place.get(one, -1) for one in theirs.tolist()], np.intp)
            self._places = theirs, law.ids, found
        return self._places[2]

    def take_classes(self) -> None:
        """Let robots of the law have the motion of their classes, as those of the base have."""
        if self.law is not None:
            self._sync(self.law)
            self._take_motions(self.law)

    def _take_motions(self, law: MooredLaw) -> None:
        law.own = np.full((2, len(law)), np.nan)
        law.own[:, self.places()] = self.base.own

    def join(self, known: int, found: int, sigma: float, fits: float) -> None:
        """Take in that two robots of `base` are one (see `AlternativeLaws`)."""
        law = self.law
        if law is None:
            return
        self._sync(law)
        known, found = self.places()[[known, found]].tolist()
        if not law.sway[known]:
            return
        slots = np.array([known])
        before = law.own_covariances(slots)
        apart, spread = law.join(known, found, sigma)
        squared, size = mahalanobis(apart, spread)
        self.evidence += -0.5 * float(squared + size) - fits
        self.evidence += self.leaving.update(
            slots, apart[None], spread[None], np.eye(2)[None], before @ inverse(spread[None])
        )
        kept = np.arange(len(law)) != found
        law.drop(np.array([found]))
        self.swing.keep(kept, 0)
        self.leaving.keep(kept, 0)

    def _compare(self, law: MooredLaw, found: Outcome, base: Outcome, before: Array) -> None:
        """Take in how well an image fitted both laws.

        Args:
            law: of the hypothesis.
            found: how well it fitted that.
            base: how well it fitted `base`.
            before: (m, 2, 2) what was uncertain of where the law shows robots (`own_covariances`).
        """
        moored = law.sway[found.slots] > 0.0
        seen = found.slots[moored]
        if found.count == base.count:
            self.evidence += found.log_likelihood - base.log_likelihood
            residual, spread = found.given_others()
            by_place, own = found.by_place[moored], spread[moored]
            followed = before[moored] @ by_place.swapaxes(1, 2) @ inverse(own) @ by_place
            self.evidence += self.leaving.update(seen, residual[moored], own, by_place, followed)
        if len(seen):
            self.swing.update(seen, found.normalised()[moored], self._step_s)
            odds = self.leaving.odds[seen]
            leaving = int((odds > CLEAR_NATS).sum())
            if leaving > 1 and 2 * leaving > np.count_nonzero(law.sway):
                self.reset()
                return
            if leaving:
                self._release(law, int(seen[odds.argmax()]))
        if self.evidence < TUNING.given_up_nats:
            self.reset()

    def _release(self, law: MooredLaw, slot: int) -> None:
        """Let a robot swim that has left."""
        law.release(slot, *self.leaving.gone(slot))
        self.leaving.end(slot)

    def _ask(self) -> None:
        """Ask which robots that are in view may be moored, or drift as the others do."""
        if self.law is None:
            begin = self._first()
            if not begin:
                return
            self.law = self._begin()
            self.evidence = TUNING.first_nats
            self.leaving, self.swing = CastingOff(len(self.law)), Swing(len(self.law))
            for slot in begin:
                self._moor(self.law, slot, TUNING.joins_nats)
        while slots := self._eligible(self.law):
            odds = self.law.odds(slots)
            best = int(odds.argmax())
            if odds[best] < TUNING.joins_nats:
                break
            self._moor(self.law, slots[best], float(odds[best]))
        if self._stay(self.law) < TUNING.least_robots:
            self.reset()

    def begin_as(self, drifting: MooredHypothesis, least: float) -> None:
        """Begin with what is known where robots drift, now that they may do so by nothing.

        Args:
            drifting: the hypothesis that they drift.
            least: log odds to it from which this one is tried, nats.
        """
        other = drifting.law
        if self.law is not None or other is None:
            return
        odds = other.still_odds()
        if odds > least:
            self.law, self.evidence = other.without_current(), drifting.evidence + odds
            self.swing, self.leaving = copy.deepcopy((drifting.swing, drifting.leaving))

    def _move(
        self, law: MooredLaw, seconds: float, keep: Array, stationary: Array, motion: MotionModel
    ) -> None:
        law.predict(seconds, keep, stationary, motion)

    def _stay(self, law: MooredLaw) -> int:
        """Return how many robots of the law are moored."""
        return int(np.count_nonzero(law.sway))

    def _begin(self) -> MooredLaw:
        """Return a law of the hypothesis in which no robot is moored yet."""
        return MooredLaw.of(self.base, self.adrift)

    def _first(self) -> list[int]:
        """Return the robots of `base` with which the hypothesis begins."""
        asked = self._eligible(self.base)
        if not self.adrift:
            return likely_still(self.base, asked, TUNING.joins_nats)
        one = most_alike(self.base, asked, TUNING.joins_nats)
        return [one] if one >= 0 else []

    def _moor(self, law: MooredLaw, slot: int, odds: float) -> None:
        law.moor(slot)
        self.swing.begin(slot)
        self.leaving.begin(slot, -odds)

    def _eligible(self, law: JointState) -> list[int]:
        """Return the robots in view that swim so far and were watched for long enough."""
        latest = self._now_s - TUNING.watched_s
        free = law.unseen == 0.0 if law.sway is None else (law.unseen == 0.0) & (law.sway == 0.0)
        slots: list[int] = np.flatnonzero(free).tolist()
        names = law.ids[slots].tolist()
        return [
            slot
            for slot, one in zip(slots, names, strict=True)
            if self._first_seen_s.get(one, math.inf) <= latest
        ]

    def _sync(self, law: MooredLaw) -> None:
        """Let the law have the robots that the base has."""
        theirs = self.base.ids
        if self._synced[0] is theirs and self._synced[1] is law.ids:
            return
        kept = np.isin(law.ids, theirs)
        kept[law.current] = True
        law.drop(np.flatnonzero(~kept))
        new = np.flatnonzero(~np.isin(theirs, law.ids))
        for slot in new.tolist():
            law.take(self.base, slot)
        self.swing.keep(kept, len(new))
        self.leaving.keep(kept, len(new))
        self._take_motions(law)
        self._synced = theirs, law.ids
