# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Moments of robots over three laws: all swim; some stay; some drift with one current.

Which law holds is never decided. Each is weighed by its evidence (`moored`), and what is published
has the mixture's moments, robot by robot: one that may have left the others swims with that
probability. So does one that no image shows any more: nothing would tell that it leaves. No law's
evidence falls further behind than what may have changed since: boats cast off, and a tide turns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.moored import MooredHypothesis
from aerial_gnss_ros.core.filter.moored_law import MooredLaw
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange, likelier, recalibrate
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.evidence import UNCLEAR
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import LATENCY, PlatformModel
from aerial_gnss_ros.core.values.estimates import Current

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MooredMixtureTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    swimming_behind_nats: float = 6.0
    """How far behind the likeliest law the one is at most in which all swim. Judged."""
    behind_nats: float = 4.0
    """The same for the others while they are tried. Judged."""


TUNING = MooredMixtureTuning()

Published = Callable[[MooredLaw, JointState], tuple[Array, Array]]


def _alone(law: MooredLaw, _base: JointState) -> tuple[Array, Array]:
    return law.published()


class MooredGroup:
    """The hypotheses of one joint law.

    Args:
        base: the law that lets all robots swim.

    Attributes:
        both: that some stay, and that some drift.
    """

    def __init__(self, base: JointState) -> None:
        self.base = base
        # A list: a snapshot of the state shares what a tuple holds.
        self.both = [MooredHypothesis(base, adrift=False), MooredHypothesis(base, adrift=True)]

    def update(
        self, outcome: Outcome, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> None:
        """Take in an image that `base` has taken in already (see `MooredHypothesis`)."""
        for one in self.both:
            one.update(outcome, pixels, view, model, level)
        self.both[0].begin_as(self.both[1], -TUNING.behind_nats)
        odds = [one.odds for one in self.both]
        best = max(odds)
        beyond = max(best - TUNING.swimming_behind_nats, 0.0)
        for one, own in zip(self.both, odds, strict=True):
            if one.law is not None:
                one.evidence += max(best - TUNING.behind_nats - own, 0.0) - beyond

    def weights(self) -> Array:
        """Return the probabilities (3,) that all swim, that some stay, that some drift."""
        logs = np.array([0.0, *(one.odds for one in self.both)])
        odds = np.exp(logs - logs.max())
        shares: Array = odds / odds.sum()
        return shares

    def correct_alone(
        self, slots: Indices, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> None:
        """Correct what `base` has corrected alone (see `update.correct`)."""
        for one in self.both:
            one.correct_alone(slots, pixels, view, model, level)

    def publish(
        self,
        mean: Array,
        covariance: Array,
        published: Published = _alone,
        unseen: Array | None = None,
    ) -> None:
        """Put in the mixture's moments (see `MooredMixture`).

        `unseen` (n,): for how long no image has shown each robot, s; None: the law's own.
        """
        weights, rows = self.weights(), self.base.rows
        n = len(rows)
        shown = np.exp(-(self.base.unseen if unseen is None else unseen) / MOTION_MODEL.held_s)
        shares = np.zeros((3, n))
        means, blocks = np.tile(mean[rows], (3, 1, 1)), np.tile(covariance[rows], (3, 1, 1, 1))
        for i, one in enumerate(self.both, 1):
            if one.law is None:
                continue
            places = one.places()
            there = np.flatnonzero(places >= 0)
            slots = places[there]
            states, own = published(one.law, self.base)
            means[i, there], blocks[i, there] = one.leaving.mix(slots, states[slots], own[slots])
            shares[i, there] = weights[i] * shown[there]
        shares[0] = 1.0 - shares[1:].sum(axis=0)
        mixed = (shares[:, :, None] * means).sum(axis=0)
        apart = means - mixed
        blocks += apart[:, :, :, None] * apart[:, :, None]
        mean[rows], covariance[rows] = mixed, (shares[:, :, None, None] * blocks).sum(axis=0)

    def current(self) -> tuple[float, Current] | None:
        """Return the probability that robots drift, and with which current; None: none may."""
        law = self.both[1].law
        if law is None:
            return None
        mean, covariance = law.known_current()
        return float(self.weights()[2]), Current(mean, covariance)


class MooredMixture:
    """The hypotheses of all groups of robots."""

    def __init__(self) -> None:
        self._all: list[MooredGroup] = []

    def reset(self) -> None:
        """Give all of them up: the laws were changed by what was no image."""
        self._all = []

    def _of(self, group: JointState) -> MooredGroup:
        found = next((one for one in self._all if one.base is group), None)
        if found is None:
            found = MooredGroup(group)
            self._all.append(found)
        return found

    def reconfigure(self) -> None:
        """Use the groups' new motion models from now on."""
        for group in self._all:
            for one in group.both:
                one.take_classes()

    def recalibrate(self, change: CalibrationChange, prior: Array, sight: CameraView) -> None:
        """Continue with another calibration, before the groups do (see `recalibration`).

        What laws do not model, and the latency, makes them begin anew.
        """
        if change.errors[LATENCY] or not change.modelled(prior):
            self.reset()
        for group in self._all:
            swim = likelier(group.base, change, prior)
            for one in group.both:
                if one.law is not None:
                    one.evidence += likelier(one.law, change, prior) - swim
                    recalibrate(one.law, change, prior, sight, searched=False)

    def join(self, group: JointState, known: int, found: int, sigma: float, fits: float) -> None:
        """Take in that two robots of a group are one (see `AlternativeLaws`)."""
        for one in self._of(group).both:
            one.join(known, found, sigma, fits)

    def settle(self, error: int, mean: float, sigma: float) -> None:
        """Take over what is known of one of the platform's errors (see `JointState`)."""
        for group in self._all:
            for one in group.both:
                if one.law is not None:
                    one.law.settle(error, mean, sigma)

    def shift(self, jump: Array) -> None:
        """Move with an accepted jump (2,) of the GNSS position, as groups do, m."""
        for group in self._all:
            for one in group.both:
                if one.law is not None:
                    one.law.shift(jump)

    def predict(
        self,
        groups: list[JointState],
        seconds: float,
        keep: Array,
        stationary: Array,
        motion: MotionModel,
    ) -> None:
        """Move on in time, before the groups do (see `JointState.predict`)."""
        self._all = [self._of(group) for group in groups]
        for group in self._all:
            for one in group.both:
                one.predict(seconds, keep, stationary, motion)

    def update(
        self,
        group: JointState,
        outcome: Outcome,
        pixels: Array,
        view: CameraView,
        model: PlatformModel,
        level: float,
    ) -> None:
        """Take in an image that a group has taken in already (see `MooredHypothesis`)."""
        self._of(group).update(outcome, pixels, view, model, level)

    def correct_alone(
        self,
        group: JointState,
        slots: Indices,
        pixels: Array,
        view: CameraView,
        model: PlatformModel,
        level: float,
    ) -> None:
        """Correct what a group has corrected alone (see `update.correct`)."""
        self._of(group).correct_alone(slots, pixels, view, model, level)

    def publish(
        self,
        groups: list[JointState],
        mean: Array,
        covariance: Array,
        published: Published = _alone,
    ) -> None:
        """Put in the moments of robots over all laws.

        Not where the camera may have turned by itself: then that is what robots are judged by.

        Args:
            groups: the present ones.
            mean: (n, 4) of all robots by their rows, in which all swim.
            covariance: (n, 4, 4) likewise.
            published: returns states and covariances of a law's robots, of its group.
        """
        for group in groups:
            turned = group.velocity_changes.position_covariances.any()
            if not turned and any(one.law is not None for one in self._of(group).both):
                self._of(group).publish(mean, covariance, published)

    def current(self) -> Current | None:
        """Return with which current robots drift; None where that is not likely enough."""
        found = [one for one in (group.current() for group in self._all) if one is not None]
        likely, best = max(found, key=lambda one: one[0], default=(0.0, None))
        return best if likely > 1.0 - UNCLEAR else None
