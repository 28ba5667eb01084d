# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rotation fault: the camera turns without its telemetry saying so.

Then all robots in view seem to start moving at once, at -A w for the rotation rate w, with A the
derivative of positions by the platform's angles. While that is slower than robots can be, no single
image distinguishes it from moving robots; the onset does, since robots that manoeuvre independently
do not move as one rotation would by chance. The recent velocity changes have a known covariance
(`velocity_changes`), and `rotation_test` compares the two hypotheses, once per camera for all
blocks.

A fleet that sets out in formation looks the same, so nothing is decided: the filter continues with
moving robots, and the covariance published is inflated by the displacement that the camera
hypothesis implies: A W A' for a robot in view, W = (w t)(w t)' after a time t plus the uncertainty
of w t. It is kept out of the filter, whose drift models do not cover a rotation: the filter would
learn something false. When all robots seem to reverse, the angle decreases; and once a rotation has
ended, w t is known better (its joint distribution with w, conditioned on w = 0 now).

Boxes that fit no robot are handled by `attitude_ambiguity`, which adds to W.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.attitude_ambiguity import AttitudeAmbiguity
from aerial_gnss_ros.core.faults.formation import TUNING as FORMATION
from aerial_gnss_ros.core.faults.rotation_test import TUNING as ROTATION_TEST
from aerial_gnss_ros.core.faults.rotation_test import fit_rotation
from aerial_gnss_ros.core.faults.velocity_changes import VelocityChanges
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS, SURE_SIGMAS

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class RotationFaultTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    judged_every_s: float = 0.5
    """Interval between tests, s. Judged."""
    changes_nats: float = 1.0
    """Log odds at which an assumed rotation is changed. Judged."""
    looked_s: float = 2.0
    """Time until a rotation shows in the velocities, s. Judged."""
    refined_s: float = 3.0
    """Time for which the rate of a new rotation is refined, s. Judged."""
    rate_share: float = 0.3
    """Relative uncertainty of its rate, one sigma. Judged."""
    uneven_share: float = 0.1
    """Relative uncertainty of its angle after it has ended, one sigma: rates vary. Judged."""


TUNING = RotationFaultTuning()


@dataclass(frozen=True)
class RobotsInView:
    """Robots of one joint state in an image.

    Attributes:
        changes: of all robots of that state.
        slots: (n,) the robots.
        by_angles: (n, 2, 3) derivatives of their positions by the platform's angles, m/rad.
        unknown: (n,) variance of their velocities, both axes, m²/s².
        fastest: (n,) greatest speeds, m/s; or one for all.
    """

    changes: VelocityChanges
    slots: Indices
    by_angles: Array
    unknown: Array
    fastest: Array | float


class RotationFault:
    """Test for a rotation of one camera by all robots in view.

    Attributes:
        rate: (3,) of the assumed rotation about the axes of roll, pitch, heading, rad/s; 0 without
            one.
        angle: (3,) turned so far, rad.
        doubted: whether a rotation was ever assumed.
        ambiguity: possible rotation while no robots explained its boxes.
    """

    def __init__(self, unexplained: AttitudeAmbiguity | None = None) -> None:
        self.rate: Array = np.zeros(3)
        self.angle: Array = np.zeros(3)
        self._spread: Array = np.zeros((3, 3))
        self._law: Array = np.zeros((6, 6))  # covariance of angle and rate
        self.doubted = False
        self._lasts = self._since = 0.0
        self.ambiguity = unexplained or AttitudeAmbiguity(FORMATION.turn_sigma_rad)

    @property
    def rotating(self) -> bool:
        """Whether a rotation is assumed."""
        return bool(self.rate.any())

    @property
    def covariance(self) -> Array:
        """(3, 3) covariance W of the angles, rad²."""
        turned = np.outer(self.angle, self.angle) + self._law[:3, :3]
        most = 3.0 * FORMATION.turn_sigma_rad**2 / max(float(np.trace(turned)), 1e-12)
        return turned * min(1.0, most) + self.ambiguity.covariance

    @property
    def sigma(self) -> float:
        """Angle that it may have turned, one sigma, rad."""
        if not self.doubted and not self.ambiguity.active:
            return 0.0
        return math.sqrt(np.trace(self.covariance))

    @property
    def due(self) -> bool:
        """Whether a test is due."""
        return self._since >= TUNING.judged_every_s or self.doubted or self.ambiguity.active

    def predict(self, seconds: float, keep: float) -> None:
        """Advance in time.

        Args:
            seconds: length of the step, s.
            keep: factor by which the angles' errors decay.
        """
        self._since += seconds
        if not self.doubted:
            return
        self.angle *= keep
        self._law[:3] *= keep
        self._law[:, :3] *= keep
        if self.rotating:
            self._lasts += seconds
            self._run(seconds)

    def judge(
        self, seen: Sequence[RobotsInView], others: Sequence[RobotsInView] = (), noise: float = 1.0
    ) -> None:
        """Test the robots in view, of all blocks together, when due.

        Args:
            seen: these robots.
            others: tracks in view that tell nothing of the camera, but are displaced with it.
            noise: by what factor variances may be larger (`NoiseLevel.unknown`).
        """
        if seen and self._since >= TUNING.judged_every_s:
            self._since = 0.0
            self._weigh(seen, noise)
        for one in (*seen, *others):
            self.spread(one.changes, one.slots, one.by_angles)

    def spread(
        self, changes: VelocityChanges, slots: Indices, by_angles: Array, seen: bool = True
    ) -> None:
        """Inflate robots' covariances by the present ambiguity (see `judge`).

        Args:
            changes: of their joint state.
            slots: the robots.
            by_angles: (n, 2, 3) m/rad.
            seen: whether they are in the image; covariances of others do not decrease.
        """
        across = by_angles.swapaxes(1, 2)
        rates = np.outer(self.rate, self.rate) + self._spread
        places, velocities = by_angles @ self.covariance @ across, by_angles @ rates @ across
        places = places + self.ambiguity.apart * np.eye(2)
        changes.widen(slots, places, velocities, seen)

    def _weigh(self, seen: Sequence[RobotsInView], noise: float) -> None:
        swerve = ROTATION_TEST.swerve_share
        change, spread, gain = fit_rotation(
            np.concatenate([one.changes.sums(one.slots) for one in seen]),
            noise * np.concatenate([one.changes.variances(one.slots, one.unknown) for one in seen]),
            np.concatenate([one.by_angles for one in seen]),
            np.concatenate([np.full(len(one.slots), swerve * one.fastest) for one in seen]),
        )
        refines = self.rotating and self._lasts < TUNING.looked_s + TUNING.refined_s
        if not refines and gain < (TUNING.changes_nats if self.rotating else CLEAR_NATS):
            return
        begins, before = not self.rotating, self.rate
        self._spread = self._spread + spread
        self._law[3:, 3:] += spread
        if refines:  # it has applied from the beginning
            self.angle = self.angle + self._lasts * change
            self._law[:3, :3] += self._lasts**2 * spread
            self._law[:3, 3:] += self._lasts * spread
            self._law[3:, :3] += self._lasts * spread
        self.rate = before + change
        if self.rate @ np.linalg.solve(self._spread, self.rate) < SURE_SIGMAS**2:
            self._end(before)
        elif begins:
            self._law[3:, 3:] += TUNING.rate_share**2 * np.outer(change, change)
            self._lasts, self.doubted = TUNING.looked_s, True
            self._run(TUNING.looked_s)
        for one in seen:
            one.changes.explain(one.slots, one.by_angles @ (self.rate - before))

    def _run(self, seconds: float) -> None:
        """Advance the angle by the assumed rotation."""
        angle = self.angle + seconds * self.rate
        self.angle = angle * min(
            1.0, FORMATION.turn_sigma_rad / max(float(np.linalg.norm(angle)), 1e-9)
        )
        self._law[:3] += seconds * self._law[3:]
        self._law[:, :3] += seconds * self._law[:, 3:]

    def _end(self, before: Array) -> None:
        """End the rotation; its past rate is known better then.

        Args:
            before: (3,) rate until now, rad/s.
        """
        if before.any():
            gain = np.linalg.solve(self._law[3:, 3:], self._law[3:, :3]).T
            self._law[:3, :3] -= gain @ self._law[3:, :3]
            uneven = TUNING.uneven_share * self._lasts * before
            self._law[:3, :3] += np.outer(uneven, uneven)
        self._law[3:] = self._law[:, 3:] = 0.0
        self.rate, self._spread, self._lasts = np.zeros(3), np.zeros((3, 3)), 0.0
