# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that begin anew: a wrong latency or calibration had displaced them and their platform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.alternative_laws import AlternativeLaws
from aerial_gnss_ros.core.filter.linearization import CameraView, relinearize
from aerial_gnss_ros.core.filter.recalibration import restore_priors
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.motion_model import MotionModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RestartsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    sure_s: float = 0.1
    """An unknown latency counts as known once its sigma is at most this, s. Judged."""
    unsure_s: float = 0.2
    """A known latency counts as unknown once its sigma is above this, s. Judged."""
    feigned_mps: float = 2.0
    """Apparent speed of a robot that a wrong latency can cause, one sigma, m/s. Judged."""


TUNING = RestartsTuning()


class Restarts:
    """Lets robots begin anew with their next boxes.

    Args:
        laws: beside the joint states.

    Attributes:
        late: whether the latency is unknown. Until it is known, robots begin anew with each image.
    """

    def __init__(self, laws: AlternativeLaws) -> None:
        self._laws = laws
        self.reset(0.0)

    def reset(self, variance: float) -> None:
        """Begin with the latency's prior variance, s²."""
        self.late = variance > TUNING.sure_s**2
        self._found = self._recalibrated = False

    def note_latency(self, sigma: float) -> None:
        """Note how well the latency is known, one sigma, s."""
        before, self.late = self.late, sigma > (TUNING.sure_s if self.late else TUNING.unsure_s)
        self._found = not self.late and (before or self._found)

    def note_recalibration(self) -> None:
        """Note a new calibration of what the filter does not estimate."""
        self._recalibrated = True

    def apply(
        self,
        group: JointState,
        slots: Indices,
        view: CameraView,
        stationary: Array,
        motion: MotionModel,
    ) -> None:
        """Let robots begin anew where the latency or another calibration demands it.

        Args:
            group: the joint state.
            slots: of robots that the image shows.
            view: the image's camera.
            stationary: (9, 9) prior covariance of the platform's errors.
            motion: motion model of the robots.
        """
        if self.late or self._found:
            self._laws.restart()
            relinearize(group, view)
            # Otherwise robots seem too fast.
            feigned = TUNING.feigned_mps if self.late else 0.0
            speeds = group.motion(motion, slots).speed_sigma
            group.forget(slots, stationary, speeds + feigned)
        if self._recalibrated:
            self._laws.times.restart()
            relinearize(group, view)
            speeds = group.motion(motion, slots).speed_sigma
            restore_priors(group, slots, stationary, speeds)

    def done(self) -> None:
        """Note that all robots of an image have begun anew."""
        self._found = self._recalibrated = False
