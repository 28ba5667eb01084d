# SPDX-License-Identifier: Apache-2.0
"""What a camera may have turned by itself while no robots explained its boxes.

Boxes that no robots explain (too fast, or elsewhere) do not move the robots. But those that are
found anew may be seen by a camera that has turned meanwhile: the covariance D of its angles grows.

Robots that are found again tell. If the camera did not turn and it was the boxes that were wrong,
such a robot is off where it was expected by d of covariance S; if it did, of S + A D A', with A
the derivative of places by the angles. So much less likely is it, from even odds on, that D
counts, and D itself is narrowed as by any measurement.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE = math.radians(20.0)
"""One sigma of the rate at which a camera turns whose boxes no robots explain, each axis, rad/s."""

ALREADY_S = 0.3
"""For so long it has turned when that is noticed, s."""


class Unexplained:
    """Of one camera, from one time to the next that no robots explain its boxes.

    Args:
        most: angle up to which doubt grows, one sigma of each axis, rad.
    """

    def __init__(self, most: float) -> None:
        self._most_s = most / RATE
        self._earlier: Array = np.zeros((3, 3))  # of times before the last one
        self._spread: Array = np.zeros((3, 3))  # D, of the last one
        self._odds: float | None = None  # logarithm; that D counts; nothing has told yet
        self._lasts = self._grown = self._ago = 0.0
        self.doubts = False  # whether there ever was a doubt

    @property
    def doubt(self) -> Array:
        """(3, 3) covariance of the angles, rad²."""
        share = 1.0 if self._odds is None else 0.5 + 0.5 * math.tanh(0.5 * self._odds)
        return self._earlier + share * self._spread

    def predict(self, seconds: float, keep: float) -> None:
        """Move on in time.

        Args:
            seconds: length of the step, s.
            keep: factor by which the angles' errors still count after it.
        """
        self._ago += seconds
        if self.doubts:
            self._earlier *= keep * keep
            self._spread *= keep * keep

    def take(self, seconds: float, over: bool = False) -> None:
        """Take in that for so long no robots explained the boxes, s; 0: some do.

        Args:
            seconds: time since the last image, s.
            over: whether these are robots that were seen before, where they should be.
        """
        if not seconds:
            if self._lasts and over:
                self._spread = np.zeros((3, 3))
            self._lasts = 0.0
        elif not self._lasts:  # one image may be in error
            self._earlier = self.doubt
            self._spread, self._odds, self._grown = np.zeros((3, 3)), None, 0.0
            self._lasts = ALREADY_S + seconds
            self._ago = seconds
        else:
            self._lasts += seconds
            before, self._grown = self._grown, min(self._lasts, self._most_s)
            self._spread = self._spread + RATE**2 * (self._grown**2 - before**2) * np.eye(3)
            self.doubts = True

    def found(self, unseen: float, by_angles: Array, apart: Array, spread: Array) -> None:
        """Take in where a robot was found again.

        Args:
            unseen: time since it was seen before, s.
            by_angles: (2, 3) A, how its place moves with the platform's angles, m/rad.
            apart: (2,) d, from where it was expected, m.
            spread: (2, 2) S, covariance of that if the camera did not turn, m².
        """
        if not self._spread.any() or unseen < self._ago - 1e-6:
            return  # nothing to tell, or by the same camera
        with_it = self._spread @ by_angles.T
        wide = by_angles @ with_it + spread
        self._odds = (self._odds or 0.0) + _log_density(apart, wide) - _log_density(apart, spread)
        gain = np.linalg.solve(wide, with_it.T).T
        told = gain @ apart
        self._spread = self._spread - gain @ with_it.T + np.outer(told, told)


def _log_density(error: Array, spread: Array) -> float:
    """Return the logarithm of a normal density but for a constant."""
    squared = float(error @ np.linalg.solve(spread, error))
    return -0.5 * (squared + float(np.linalg.slogdet(spread)[1]))
