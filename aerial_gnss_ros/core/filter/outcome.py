# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How well an image fitted the joint state that it updated."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.predicted_pixels import Linear
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.measurement_model import POSE_COUNT
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.numerics.gaussian import inverse

Array = NDArray[np.float64]

_NOTHING = Linear(
    np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros((0, 2, COUNT)), np.zeros((0, 2, POSE_COUNT)),
    np.zeros(0, np.bool_),
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Fit of an image.

    Attributes:
        squared: normalised squared innovation of the whole image.
        count: its degrees of freedom.
        refused: slots of robots whose boxes were refused because they imply an impossible speed.
        log_likelihood: of the image, nats, up to a constant per degree of freedom.
        slots: of the updated robots.
        residual: (m, 2) of their boxes, px.
        spread: (2 m, 2 m) covariance of that, px².
        linear: the linearisation of these boxes that was used.
        white: (2 m,) the residual at the final estimate, less the change that is expected, in units
            of `spread`'s root; the state was corrected by the gain times this.
    """

    squared: float
    count: int
    refused: Indices = field(default_factory=lambda: np.zeros(0, np.intp))
    log_likelihood: float = 0.0
    slots: Indices = field(default_factory=lambda: np.zeros(0, np.intp))
    residual: Array = field(default_factory=lambda: np.zeros((0, 2)))
    spread: Array = field(default_factory=lambda: np.zeros((0, 0)))
    linear: Linear = _NOTHING
    white: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def by_place(self) -> Array:
        """(m, 2, 2) derivative of the pixels by the robots' East, North, px/m."""
        return self.linear.by_place

    def normalised(self) -> Array:
        """Return each robot's own residual by its own covariance, (m, 2)."""
        m = len(self.slots)
        east = np.arange(0, 2 * m, 2)
        a = np.sqrt(self.spread[east, east])
        b = self.spread[east + 1, east] / a
        d = np.sqrt(self.spread[east + 1, east + 1] - b * b)
        white = np.empty((m, 2))
        white[:, 0] = self.residual[:, 0] / a
        white[:, 1] = (self.residual[:, 1] - b * white[:, 0]) / d
        return white

    def given_others(self) -> tuple[Array, Array]:
        """Return each robot's residual (m, 2) given all others, and its covariance (m, 2, 2).

        What the boxes of an image have in common, such as a camera that shakes, cancels.
        """
        m = len(self.slots)
        every = np.arange(m)
        precision = np.asarray(np.linalg.inv(self.spread), dtype=np.float64)
        own = inverse(precision.reshape(m, 2, m, 2)[every, :, every])
        told = (precision @ self.residual.ravel()).reshape(m, 2, 1)
        return (own @ told)[:, :, 0], own
