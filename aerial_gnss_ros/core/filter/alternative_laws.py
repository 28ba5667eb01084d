# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Laws beside the joint states: that robots stay or drift, and that slow errors last otherwise.

They take in each image that the joint states have taken in, and tell by their evidence whether they
hold. Where joint states were changed by what is no image, they begin anew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.correlation_times import CorrelationTimes
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.moored_mixture import MooredMixture
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel

Array = NDArray[np.float64]


class AlternativeLaws:
    """The laws beside one filter's joint states.

    Args:
        model: of the platform.
        find_moored: whether it is asked if robots stay.

    Attributes:
        moored: weighs whether robots that seem to stay do; None: that is not asked.
        times: weighs for how long the platform's slow errors last, by the first group.
    """

    def __init__(self, model: PlatformModel, find_moored: bool) -> None:
        self._model = model
        self.moored = MooredMixture() if find_moored else None
        self.times = CorrelationTimes(model)

    def reset(self) -> None:
        """Begin anew with the stated correlation time."""
        self.times.reset()
        self.restart()

    def restart(self) -> None:
        """Begin anew: the joint states were changed by what is no image."""
        if self.moored is not None:
            self.moored.reset()
        self.times.restart()

    def shift(self, jump: Array) -> None:
        """Move with an accepted jump (2,) of the GNSS position, as groups do, m."""
        if self.moored is not None:
            self.moored.shift(jump)
        self.times.shift(jump)

    def predict(
        self,
        groups: list[JointState],
        seconds: float,
        stationary: Array,
        motion: MotionModel,
        late: bool,
    ) -> None:
        """Move on in time, before the groups do (see `JointState.predict`).

        `late` is whether the latency is unknown: then correlation times are not weighed.
        """
        if not late:
            self.times.predict(groups[0], seconds, stationary, motion)
        if self.moored is not None:
            keep = self._model.decay(seconds)
            self.moored.predict(groups, seconds, keep, stationary, motion)

    def correct_alone(
        self,
        group: JointState,
        first: bool,
        slots: Indices,
        pixels: Array,
        view: CameraView,
        level: float,
    ) -> None:
        """Correct what a group has corrected alone (see `update.correct`).

        Args:
            group: the joint state.
            first: whether it is the first group.
            slots: (m,) of its robots.
            pixels: (m, 2) of their boxes.
            view: the camera.
            level: factor by which white noise is larger than stated.
        """
        if self.moored is not None:
            self.moored.correct_alone(group, slots, pixels, view, self._model, level)
        if first:
            self.times.correct_alone(slots, pixels, view, level)

    def join(self, group: JointState, known: int, found: int, sigma: float, fits: float) -> None:
        """Take in that a group has two robots that are one, as it has.

        Args:
            group: the joint state.
            known: place of the one that no image had shown for a while.
            found: place of the one that it is.
            sigma: one sigma of how far they may be apart, m.
            fits: log density of their distance in that state, nats.
        """
        if self.moored is not None:
            self.moored.join(group, known, found, sigma, fits)
        self.times.join(group, known, found, sigma, fits)

    def update(
        self,
        group: JointState,
        first: bool,
        outcome: Outcome,
        pixels: Array,
        view: CameraView,
        level: float,
    ) -> bool:
        """Take in an image that a group has taken in; return whether another time is assumed now.

        Args:
            group: the joint state.
            first: whether it is the first group.
            outcome: how well the image fitted it.
            pixels: (m, 2) of the boxes that were used.
            view: the camera.
            level: factor by which white noise is larger than stated.
        """
        if self.moored is not None:
            self.moored.update(group, outcome, pixels, view, self._model, level)
        if not first or not self.times.update(outcome, pixels, view, level):
            return False
        if self.moored is not None:
            self.moored.reset()
        return True
