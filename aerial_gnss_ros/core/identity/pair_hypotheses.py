# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Multiple-hypothesis tracking of two robots that are close to one another.

Each image doubles the hypotheses, one for each assignment of its two boxes. They are weighted by a
motion model of robots that meet: these turn, but hardly change speed, and keep turning for a while.
Acceleration is a multiple of `noise.robot_acceleration`; the turn rate is a Gauss-Markov process
(coordinated turn: Bar-Shalom, Li, Kirubarajan 2001, 11.7) plus white changes of course,
`TUNING.course_density`. Whether the two crossed or turned away follows from speeds, courses and
turn rates before and after, jointly.

Common errors of both boxes cancel if they are white or drift; a common jump is treated as noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PairHypothesesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    max_hypotheses: int = 12
    """Greatest number of hypotheses of a pair. Judged."""
    least_log: float = -12.0
    """Log weight, relative to the best, below which a hypothesis is dropped. Judged."""
    turn_rate_sigma: float = 0.5
    """Turn rate of a robot, one sigma, rad/s. Maximises the log likelihood of the true histories in
    `benchmarks/meetings.py --seeds 120 --first 500`."""
    turn_lasts_s: float = 1.5
    """Correlation time of the turn rate, s. Chosen in the same way."""
    course_density: float = 0.2
    """White changes of course, one sigma after a second, rad/s^0.5. Judged."""
    place_density: float = 0.1
    """Drift of both positions by the platform's slow errors, m/s^0.5. Judged."""
    same_squared: float = 0.5
    """Squared Mahalanobis distance below which two hypotheses are merged. Judged."""


TUNING = PairHypothesesTuning()


_PLACES = np.array([0, 1, 4, 5])
_BOTH = np.vstack([np.eye(2), np.eye(2)])


@dataclass(eq=False)
class PairHypotheses:
    """Hypotheses of two robots that are close to one another.

    Attributes:
        names: labels of the first and the second robot; updated when tracks exchange labels.
        states: (k, 10) position and velocity of the first, of the second robot, m, m/s; their turn
            rates, rad/s; likeliest first.
        covariances: (k, 10, 10) of these.
        log_weights: (k,) log weights.
        signs: (k,) 1.0 where the last image's labels are right, -1.0 where they are exchanged.
        seen_ns: stamp of the last image that showed both, ns.
    """

    names: tuple[str, str]
    states: Array
    covariances: Array
    log_weights: Array
    signs: Array
    seen_ns: int

    @classmethod
    def begin(
        cls, names: tuple[str, str], places: Array, velocities: Array, spread: Array, stamp_ns: int
    ) -> PairHypotheses:
        """Return a pair whose labels are certain.

        Args:
            names: of the two.
            places: (2, 2) East, North, m.
            velocities: (2, 2) m/s.
            spread: (2, 4, 4) covariance of positions and velocities.
            stamp_ns: of the image, ns.
        """
        covariance = np.zeros((1, 10, 10))
        covariance[0, :4, :4], covariance[0, 4:8, 4:8] = spread
        covariance[0, 8:, 8:] = TUNING.turn_rate_sigma**2 * np.eye(2)
        state = np.zeros((1, 10))
        state[0, :8] = np.concatenate([places, velocities], axis=1).reshape(8)
        return cls(names, state, covariance, np.zeros(1), np.ones(1), stamp_ns)

    @property
    def exchanged(self) -> float:
        """Probability that the two labels are exchanged."""
        weights = np.exp(self.log_weights)
        return float(weights[self.signs < 0.0].sum() / weights.sum())

    def exchange(self) -> None:
        """Exchange the labels, or the last image's boxes."""
        self.signs = -self.signs

    def update(
        self,
        stamp_ns: int,
        places: Array,
        own: Array,
        common: Array,
        acceleration: float,
        exchange: float = 0.0,
    ) -> float:
        """Update with the two boxes of one image.

        Returns:
            Probability that they are exchanged relative to the previous image.

        Args:
            stamp_ns: of the image, ns.
            places: (2, 2) positions of the boxes assigned to the first and the second label, m.
            own: (2, 2, 2) white covariance of each, m².
            common: (2, 2) covariance of the error common to both, m².
            acceleration: along the robot's course, root of the spectral density, m/s^1.5.
            exchange: log likelihood ratio of an exchange by tracking in the image.
        """
        self._predict((stamp_ns - self.seen_ns) * 1e-9, acceleration)
        self.seen_ns = stamp_ns
        direct, swapped = places.reshape(4), places[::-1].reshape(4)
        off = np.stack([direct - self.states[:, _PLACES], swapped - self.states[:, _PLACES]])
        spread = self.covariances[:, _PLACES][:, :, _PLACES] + self._noise(off[0, 0], own, common)
        inverse = np.linalg.inv(spread)
        gain = self.covariances[:, :, _PLACES] @ inverse
        left = self.covariances - gain @ self.covariances[:, _PLACES]
        states = self.states + np.einsum("kij,skj->ski", gain, off)
        squared = np.einsum("ski,kij,skj->sk", off, inverse, off)
        weights = self.log_weights - 0.5 * (squared + np.linalg.slogdet(spread)[1])
        k = len(self.states)
        signs = np.repeat([1.0, -1.0], k)
        changed = signs != np.tile(self.signs, 2)
        weights = weights.reshape(-1) + exchange * changed
        weights -= weights.max()
        share = np.exp(weights)
        other = float(share[changed].sum() / share.sum())
        self._keep(states.reshape(2 * k, 10), np.tile(left, (2, 1, 1)), weights, signs)
        return other

    def _noise(self, off: Array, own: Array, common: Array) -> Array:
        """Return the boxes' covariance (4, 4); an implausible common move counts as noise."""
        noise = np.zeros((4, 4))
        noise[:2, :2], noise[2:, 2:] = own
        shared = 0.5 * (off[:2] + off[2:])
        spread = self.covariances[0][np.ix_(_PLACES, _PLACES)] + noise
        expected = 0.25 * _BOTH.T @ spread @ _BOTH + common
        if shared @ np.linalg.solve(expected, shared) > SURE_SIGMAS**2:
            common = common + np.outer(shared, shared)
        return noise + _BOTH @ common @ _BOTH.T

    def _predict(self, seconds: float, acceleration: float) -> None:
        states, k = self.states.copy(), len(self.states)
        move, noise = np.tile(np.eye(10), (k, 1, 1)), np.zeros((k, 10, 10))
        course = np.array([[seconds**2 / 3.0, seconds / 2.0], [seconds / 2.0, 1.0]]) * seconds
        kept = np.exp(-seconds / TUNING.turn_lasts_s)
        for first, turn in ((0, 8), (4, 9)):
            place, velocity = slice(first, first + 2), slice(first + 2, first + 4)
            rotation = _rotations(seconds * states[:, turn])
            after = np.einsum("kij,kj->ki", rotation, states[:, velocity])
            across = np.stack([-after[:, 1], after[:, 0]], axis=1)
            states[:, place] += 0.5 * seconds * (states[:, velocity] + after)
            states[:, velocity] = after
            states[:, turn] *= kept
            move[:, place, velocity] = 0.5 * seconds * (np.eye(2) + rotation)
            move[:, velocity, velocity] = rotation
            move[:, place, turn] = 0.5 * seconds**2 * across
            move[:, velocity, turn] = seconds * across
            move[:, turn, turn] = kept
            white = TUNING.course_density**2 * across[:, :, None] * across[
                :, None
            ] + acceleration**2 * np.eye(2)
            both = np.einsum("pq,kij->kpiqj", course, white).reshape(-1, 4, 4)
            noise[:, first : first + 4, first : first + 4] = both
            noise[:, turn, turn] = TUNING.turn_rate_sigma**2 * (1.0 - kept**2)
        covariances = move @ self.covariances @ move.transpose(0, 2, 1) + noise
        covariances[:, _PLACES[:, None], _PLACES] += (
            TUNING.place_density**2 * seconds * (_BOTH @ _BOTH.T)
        )
        self.states, self.covariances = states, covariances

    def _keep(self, states: Array, covariances: Array, weights: Array, signs: Array) -> None:
        """Keep the likeliest hypotheses and merge those that coincide."""
        kept: list[int] = []
        total: list[float] = []
        for i in np.argsort(-weights, kind="stable").tolist():
            if weights[i] < TUNING.least_log:
                break
            rivals = [n for n, j in enumerate(kept) if signs[j] == signs[i]]
            if rivals:
                off = states[[kept[n] for n in rivals]] - states[i]
                near = (
                    np.einsum("na,na->n", off, np.linalg.solve(covariances[i], off.T).T)
                    < TUNING.same_squared
                )
                if near.any():
                    first = rivals[int(np.argmax(near))]
                    total[first] = float(np.logaddexp(total[first], weights[i]))
                    continue
            if len(kept) < TUNING.max_hypotheses:
                kept.append(i)
                total.append(float(weights[i]))
        self.states, self.covariances, self.signs = states[kept], covariances[kept], signs[kept]
        self.log_weights = np.array(total)


def _rotations(angles: Array) -> Array:
    """Return rotation matrices (k, 2, 2) of angles (k,), rad."""
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([c, -s, s, c], axis=1).reshape(-1, 2, 2)
