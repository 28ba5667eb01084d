# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recent velocity changes of robots, with their expected covariance, for `rotation_fault`.

Under the stated model the corrections of a robot's velocity over some seconds have a sum of known
covariance (see `manoeuvre_noise`). The variance by which a velocity was inflated because boxes did
not fit does not count, since boxes do not fit while a camera turns, except the part of it that is
still unknown.

`rotation_fault` tests whether one rotation of the camera explains these changes, and sets by how
much the robots' covariances are inflated for it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.manoeuvre_noise import TUNING as MANOEUVRE_NOISE

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class VelocityChanges:
    """Velocity changes of the robots of one block.

    Attributes:
        position_covariances: (n, 2, 2) inflation of the robots' position covariances, m².
        velocity_covariances: (n, 2, 2) the same of velocities, m²/s².
    """

    def __init__(self) -> None:
        self.position_covariances: Array = np.zeros((0, 2, 2))
        self.velocity_covariances: Array = np.zeros((0, 2, 2))
        # Rows: sum of corrections east, north; its expected square as stated; the same by inflated
        # velocities; what of that is still to come; the stated one since the last image.
        self._sums: Array = np.zeros((6, 0))

    def sums(self, slots: Indices) -> Array:
        """Return the summed corrections (m, 2) of some robots, m/s."""
        sums: Array = self._sums[:2, slots].T
        return sums

    def variances(self, slots: Indices, unknown: Array) -> Array:
        """Return the expected variance (m,) of the sums, each axis, m²/s².

        Args:
            slots: (m,) the robots.
            unknown: (m,) variance of their velocities, both axes, m²/s².
        """
        # An inflated velocity that did not change is recovered, except for what is still unknown.
        inflated = np.minimum(self._sums[3, slots], unknown)
        expected: Array = 0.5 * (self._sums[2, slots] + inflated)
        return expected

    def explain(self, slots: Indices, changes: Array) -> None:
        """Subtract explained changes (m, 2) from the sums of some robots, m/s."""
        self._sums[:2, slots] += changes.T

    def widen(self, slots: Indices, places: Array, velocities: Array, seen: bool) -> None:
        """Set the inflation of some robots' covariances.

        Args:
            slots: (m,) the robots.
            places: (m, 2, 2) m².
            velocities: (m, 2, 2) m²/s².
            seen: whether the image shows them; the inflation of unseen robots never decreases.
        """
        if not seen:
            before = np.trace(self.position_covariances[slots], axis1=1, axis2=2)
            grown = np.trace(places, axis1=1, axis2=2) > before
            slots, places, velocities = slots[grown], places[grown], velocities[grown]
        self.position_covariances[slots] = places
        self.velocity_covariances[slots] = velocities

    def predict(self, seconds: float, stated: Array | float) -> None:
        """Advance in time.

        Args:
            seconds: length of the step, s.
            stated: (n,) process noise of a velocity in this step, each axis, m²/s².
        """
        fade = math.exp(-seconds / MANOEUVRE_NOISE.correction_sum_s)
        self._sums[:2] *= fade
        self._sums[2:4] *= fade * fade
        self._sums[5] += 2.0 * stated

    def discount(self, factor: float) -> None:
        """Take the noise that caused the corrections for larger by a factor of its variance."""
        self._sums[2:4] *= factor

    def add(self, count: int) -> None:
        """Append robots."""
        self._sums = np.concatenate([self._sums, np.zeros((6, count))], axis=1)
        more = np.zeros((count, 2, 2))
        self.position_covariances = np.concatenate([self.position_covariances, more])
        self.velocity_covariances = np.concatenate([self.velocity_covariances, more])

    def drop(self, kept: NDArray[np.bool_]) -> None:
        """Remove the robots that are not kept (n,)."""
        self._sums = self._sums[:, kept]
        self.position_covariances = self.position_covariances[kept]
        self.velocity_covariances = self.velocity_covariances[kept]

    def inherit(self, old: int, new: int, change: Array, unknown: float) -> None:
        """Let robot `new` continue as `old`, after re-identification.

        Args:
            old: its slot.
            new: likewise.
            change: (2,) of the velocity from the one to the other, m/s.
            unknown: variance of its velocity, both axes, m²/s².
        """
        self._sums[:2, new] = self._sums[:2, old] + change
        self._sums[2:, new] = *(self._sums[2:4, old] + [0.0, unknown]), unknown, 0.0

    def copy(self, other: VelocityChanges, slot: int) -> None:
        """Let the last robot continue the statistics of robot `slot` of another block."""
        self._sums[:, -1] = other._sums[:, slot]

    def note_inflation(self, slots: Indices | slice, variance: Array | float) -> None:
        """Record an inflation of velocity variances, each axis, m²/s²."""
        self._sums[4, slots] += 2.0 * variance

    def update(self, slots: Indices | slice, changes: Array, expected: Array) -> None:
        """Update with an image's velocity corrections.

        Args:
            slots: m robots.
            changes: (m, 2) corrections of their velocities, m/s.
            expected: (m,) their expected squares, m²/s².
        """
        sums = self._sums[:, slots]
        # In the long run corrections are as large as what the stated acceleration adds.
        allowed = np.minimum(np.maximum(expected - sums[5], 0.0), sums[4])
        sums[:2] += changes.T
        sums[2:5] += expected - allowed, allowed, -allowed
        sums[5] = 0.0
        self._sums[:, slots] = sums


class UnwatchedChanges(VelocityChanges):
    """Keeps nothing: of robots in a law of which no rotation is suspected."""

    def predict(self, seconds: float, stated: Array | float) -> None:
        """Do nothing."""

    def add(self, count: int) -> None:
        """Do nothing."""

    def drop(self, kept: NDArray[np.bool_]) -> None:
        """Do nothing."""

    def inherit(self, old: int, new: int, change: Array, unknown: float) -> None:
        """Do nothing."""

    def copy(self, other: VelocityChanges, slot: int) -> None:
        """Do nothing."""

    def note_inflation(self, slots: Indices | slice, variance: Array | float) -> None:
        """Do nothing."""

    def update(self, slots: Indices | slice, changes: Array, expected: Array) -> None:
        """Do nothing."""
