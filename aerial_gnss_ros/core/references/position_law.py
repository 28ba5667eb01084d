# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The normal law of robots and of the receiver's offset, and what it becomes by known positions.

A known position is conditioned on, not filtered: its error is the same in every image, so that it
must count once however many images there are. The filter's own law stays as it is, so that a wrong
reference can be left out again without a trace.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import inverse_of_errors
from aerial_gnss_ros.core.filter.state_arrays import Indices, StateArrays
from aerial_gnss_ros.core.models.platform_model import COUNT, GNSS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlatformKnowledge:
    """Some linear functions of the platform's errors, with their values.

    Attributes:
        by_errors: (m, 9 N) derivatives by the errors of N drones.
        value: (m,) m.
        spread: (m, m) covariance of the values, m².
    """

    by_errors: Array
    value: Array
    spread: Array

    def later(self, keep: Array, stationary: Array) -> PlatformKnowledge:
        """Return it after the errors have drifted (Gauss-Markov), each by its own time.

        Such a process is the same backward in time: the errors of then are `keep` times those of
        now, and a rest that is independent of these.

        Args:
            keep: (9 N,) factors by which their old values still count.
            stationary: (9 N, 9 N) their covariance when nothing is known of them.
        """
        drift = (1.0 - np.outer(keep, keep)) * stationary
        spread = self.spread + self.by_errors @ drift @ self.by_errors.T
        return PlatformKnowledge(self.by_errors * keep, self.value, spread)


@dataclass(frozen=True)
class PositionLaw:
    """Robots that share one covariance with the platform, or with those of N drones.

    Attributes:
        rows: (n,) which robots of the whole program these are.
        mean: (9 N + 4 n,) of the platforms' errors and robots, see `StateArrays`.
        covariance: (9 N + 4 n, 9 N + 4 n).
    """

    rows: Indices
    mean: Array
    covariance: Array

    @classmethod
    def of(cls, group: StateArrays) -> PositionLaw:
        """Return the law of a group of robots."""
        return cls(group.rows, group.mean, group.covariance)

    @property
    def errors(self) -> int:
        """Number of the platforms' errors, 9 N."""
        return len(self.mean) - 4 * len(self.rows)

    @property
    def receivers(self) -> Indices:
        """Where in the state East and North of the receivers' offsets are, (2 N,)."""
        firsts = np.arange(0, self.errors, COUNT)
        return (firsts[:, None] + np.arange(GNSS.start, GNSS.stop)).ravel()

    def places(self, rows: list[int]) -> Indices:
        """Return where in the state East and North of some robots are, (2 k,)."""
        listed = self.rows.tolist()
        slots = [listed.index(row) for row in rows]
        return (self.errors + 4 * np.array(slots, np.intp)[:, None] + np.arange(2)).ravel()

    def states(self) -> tuple[Array, Array]:
        """Return robots' states (n, 4) and their covariances (n, 4, 4)."""
        n = len(self.rows)
        first = self.errors
        blocks = self.covariance[first:, first:].reshape(n, 4, n, 4).diagonal(axis1=0, axis2=2)
        return self.mean[first:].reshape(n, 4), blocks.transpose(2, 0, 1)

    def offset(self, number: int = 0) -> tuple[Array, Array]:
        """Return a drone's receiver's offset (2,), m, and its covariance (2, 2), m²."""
        own = self.receivers[2 * number : 2 * number + 2]
        return self.mean[own], self.covariance[np.ix_(own, own)]

    def known(self, rows: list[int], positions: Array, spread: Array) -> PositionLaw:
        """Return the law given where some robots are.

        Args:
            rows: k of them.
            positions: (k, 2) East, North, m.
            spread: (k, 2, 2) covariances of these, m².
        """
        own = self.places(rows)
        cross = self.covariance[own]
        gain = np.linalg.solve(cross[:, own] + blocks_apart(spread), cross)
        mean = self.mean + (positions.ravel() - self.mean[own]) @ gain
        return PositionLaw(self.rows, mean, self.covariance - cross.T @ gain)

    def turned(
        self, rows: list[int], positions: Array, spread: Array, by_angles: Array, angles: Array
    ) -> Array:
        """Return how uncertain (n, 2, 2) a rotation of the camera leaves robots, m².

        It displaces those of known position, too, so that it is known but for what they do not
        show. About the mean of `known`, which takes that for another error.

        Args:
            rows: k robots whose positions are known.
            positions: (k, 2) East, North, m.
            spread: (k, 2, 2) covariances of these, m².
            by_angles: (m, 2, 3) derivatives of all robots' positions by the angles, m/rad.
            angles: (3, 3) covariance of the rotation, rad².
        """
        own, everyone = self.places(rows), self.places(self.rows.tolist())
        total = self.covariance[np.ix_(own, own)] + blocks_apart(spread)
        moved = by_angles[rows].reshape(-1, 3)
        gain = np.linalg.solve(moved @ angles @ moved.T + total, moved @ angles).T
        angle = gain @ (positions.ravel() - self.mean[own])
        left = angles - gain @ moved @ angles + np.outer(angle, angle)
        followed = self.covariance[np.ix_(everyone, own)] @ np.linalg.solve(total, moved)
        apart = by_angles[self.rows] - followed.reshape(-1, 2, 3)
        found: Array = apart @ left @ apart.swapaxes(1, 2)
        return found

    def knowledge(self, rows: list[int], positions: Array, spread: Array) -> PlatformKnowledge:
        """Return what known positions of robots show of the platform's errors.

        A robot's position is a linear function of these (regression), and a rest of its own.

        Args:
            rows: k of them.
            positions: (k, 2) East, North, m.
            spread: (k, 2, 2) covariances of these, m².
        """
        own, first = self.places(rows), self.errors
        platform, cross = self.covariance[:first, :first], self.covariance[own, :first]
        by_errors = cross @ inverse_of_errors(platform)
        rest = self.covariance[np.ix_(own, own)] - by_errors @ cross.T
        apart = positions.ravel() - self.mean[own] + by_errors @ self.mean[:first]
        return PlatformKnowledge(by_errors, apart, rest + blocks_apart(spread))

    def given(self, known: PlatformKnowledge) -> PositionLaw:
        """Return the law given what is known of the platform's errors."""
        first = self.errors
        cross = known.by_errors @ self.covariance[:first]
        spread = cross[:, :first] @ known.by_errors.T + known.spread
        gain = np.linalg.solve(spread, cross)
        apart = known.value - known.by_errors @ self.mean[:first]
        return PositionLaw(self.rows, self.mean + apart @ gain, self.covariance - cross.T @ gain)


def blocks_apart(blocks: Array) -> Array:
    """Return (2 k, 2 k) with the covariances (k, 2, 2) on the diagonal."""
    k = len(blocks)
    whole = np.zeros((k, 2, k, 2))
    whole[np.arange(k), :, np.arange(k)] = blocks
    return whole.reshape(2 * k, 2 * k)
