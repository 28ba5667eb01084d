# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""For how long the platform's slow errors last: the stated correlation time, or a short one.

If errors of compass, gimbal and height change within half a minute, a filter that takes them for
constant over minutes explains what they do by motion of the robots, and is sure of it. So a second
joint state runs beside the first one, with the other correlation time. Both predict each image, and
the sum of the differences of their log likelihoods tells which one the flight bears out
(prequential evidence: Dawid 1984). It is judged every few seconds: while telemetry begins to drift,
a short time explains it for a moment, and soon does not. Once a time is clear, the second state
takes the place of the first, and the first one's time is tried from then on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.state import JointState, copy_robot
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CorrelationTimesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    quick_s: float = 30.0
    """The short correlation time, s: errors of a gimbal that follow wind and turns. Judged."""
    least_nats: float = -6.0
    """Log odds of the time that is not assumed, at first and at least: so that it is found if it
    holds later. Judged."""
    burst_s: float = 5.0
    """Time whose images are judged together, s: as long as a sensor's fault often lasts. Judged."""


TUNING = CorrelationTimesTuning()


class CorrelationTimes:
    """Weighs two correlation times by one joint state, of robots and platform.

    Args:
        model: of the platform; its correlation time becomes the likelier one.

    Attributes:
        evidence: log odds of the time that is not assumed to the other one, nats.
    """

    def __init__(self, model: PlatformModel) -> None:
        self._model, self._stated_s = model, model.correlation_time_s
        self.reset()

    def reset(self) -> None:
        """Assume the stated time."""
        self._model.correlation_time_s, self._other_s = self._stated_s, TUNING.quick_s
        self.restart()

    @property
    def unstated_s(self) -> float:
        """The assumed time where it is not the stated one, s; otherwise 0."""
        assumed = self._model.correlation_time_s
        return 0.0 if assumed == self._stated_s else assumed

    @property
    def runs(self) -> bool:
        """Whether a second joint state runs."""
        return self._base is not None

    def restart(self) -> None:
        """Weigh anew: the joint state was changed by what is no image."""
        self._base: JointState | None = None
        self._law = JointState(self._model.nominal)
        self.evidence = TUNING.least_nats
        self._since_s = self._told_nats = 0.0

    def shift(self, jump: Array) -> None:
        """Move with an accepted jump (2,) of the GNSS position, as the joint state does, m."""
        if self.runs:
            self._law.shift(jump)

    def predict(
        self, base: JointState, seconds: float, stationary: Array, motion: MotionModel
    ) -> None:
        """Move on in time, before `base` does (see `JointState.predict`)."""
        if seconds <= 0.0 or self._stated_s <= TUNING.quick_s:
            return
        if self._base is not base:
            self.restart()
            self._base, self._law = base, _copied(base)
        self._since_s += seconds
        if self._is_same():
            keep = self._model.decay(seconds, self._other_s)
            self._law.predict(seconds, keep, stationary, motion)

    def update(self, outcome: Outcome, pixels: Array, view: CameraView, level: float) -> bool:
        """Take in an image that the joint state has taken in.

        Args:
            outcome: how well the image fitted it; its m robots.
            pixels: (m, 2) of their boxes.
            view: the camera.
            level: factor by which white noise is larger than stated.

        Returns:
            Whether the other time is clearly right. Then it is assumed.
        """
        if self._base is None or not len(outcome.slots) or not self._is_same():
            return False
        try:
            found = correct(self._law, outcome.slots, pixels, view, self._model, level=level)
        except np.linalg.LinAlgError:
            self.restart()
            return False
        if found.count == outcome.count:
            self._told_nats += found.log_likelihood - outcome.log_likelihood
        if self._since_s >= TUNING.burst_s:
            self.evidence = max(self.evidence + self._told_nats, TUNING.least_nats)
            self._since_s = self._told_nats = 0.0
        if self.evidence <= CLEAR_NATS:
            return False
        base, law = self._base, self._law
        self._law, self.evidence = _copied(base), TUNING.least_nats
        base.assume(law)
        model = self._model
        model.correlation_time_s, self._other_s = self._other_s, model.correlation_time_s
        return True

    def correct_alone(self, slots: Indices, pixels: Array, view: CameraView, level: float) -> None:
        """Correct what the joint state has corrected alone (see `update.correct`)."""
        if self._base is None or not self._is_same():
            return
        try:
            correct(self._law, slots, pixels, view, self._model, level=level, alone=True)
        except np.linalg.LinAlgError:
            self.restart()

    def join(self, group: JointState, known: int, found: int, sigma: float, fits: float) -> None:
        """Take in that two robots are one (see `AlternativeLaws`)."""
        if self._base is group and self._is_same():
            self._told_nats += self._law.tie(known, found, sigma) - fits

    def inflate_velocities(self, slots: Indices, speeds: Array, seconds: float) -> None:
        """Inflate velocities as those of the joint state (see `JointState`)."""
        if self.runs and self._is_same():
            self._law.inflate_velocities(slots, speeds, seconds)

    def doubt_platform(self, platform: Array) -> None:
        """Take back what manoeuvres taught of the platform, as from the joint state.

        Args:
            platform: (9, 9) prior covariance of the platform's errors.
        """
        self._law.doubt_platform(self._law.manoeuvre_noise.take_underestimated(), platform)

    def _is_same(self) -> bool:
        """Let the second state have the robots of the first; return whether it has."""
        law, base = self._law, self._base
        assert base is not None  # noqa: S101 - it is asked for with a state only
        if law.ids is base.ids:
            return True
        law.drop(np.flatnonzero(~np.isin(law.ids, base.ids)))
        for slot in np.flatnonzero(~np.isin(base.ids, law.ids)).tolist():
            added = copy_robot(base, slot, law)
            law.ids[added] = base.ids[slot]
        if law.ids.tolist() != base.ids.tolist():
            self.restart()
            return False
        law.ids, law.own = base.ids, base.own.copy()
        return True


def _copied(base: JointState) -> JointState:
    state = JointState(base.covariance)
    state.copy(base)
    return state
