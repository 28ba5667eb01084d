# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What references read of an estimator: one drone's filter, or a fleet's."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.references.position_law import PositionLaw

Array = NDArray[np.float64]


class Source(Protocol):
    """What is estimated without references, of N drones; only read."""

    @property
    def laws(self) -> list[PositionLaw]:
        """Robots in groups that share a covariance, each with all platforms' errors."""

    @property
    def stationary(self) -> Array:
        """(9 N, 9 N) covariance of the platforms' errors when nothing is known of them."""

    @property
    def believed(self) -> Array:
        """(2 N,) sums of the receivers' jumps that were accepted, m."""

    def decay(self, seconds: float) -> Array:
        """Return the factors (9 N,) by which the errors decay over a time."""

    def final(self, law: PositionLaw) -> PositionLaw:
        """Return a law, maybe corrected by references, with what else is to be said of it."""


class FilterSource:
    """One drone's filter.

    Args:
        joint: the filter.
    """

    def __init__(self, joint: JointFilter) -> None:
        self._joint = joint

    @property
    def laws(self) -> list[PositionLaw]:
        """Robots in groups."""
        return [PositionLaw.of(group) for group in self._joint.groups]

    @property
    def stationary(self) -> Array:
        """(9, 9) covariance of the errors when nothing is known."""
        return self._joint.stationary

    @property
    def believed(self) -> Array:
        """(2,) sum of the accepted jumps, m."""
        return self._joint.trajectory.jumps.believed

    def decay(self, seconds: float) -> Array:
        """Return the factors (9,) by which the errors decay over a time."""
        return self._joint.model.decay(seconds)

    def final(self, law: PositionLaw) -> PositionLaw:
        """Return the law as it is."""
        return law
