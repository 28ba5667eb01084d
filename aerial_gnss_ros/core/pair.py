# SPDX-License-Identifier: Apache-2.0
"""Two robots that are close: their ways, by several hypotheses of which box is whose.

Each image doubles the hypotheses: its two boxes may be one way round or the other. They are judged
by how robots swim: a robot that meets another one turns, but hardly changes its speed. So its
acceleration is that of `noise.robot_acceleration`, a few times, and across its course as much more
as a change of course by `TURN` makes. Whether two robots that came within a hull's length crossed
or turned away from one another is told by their speeds and courses before and after, all at once.

Errors that both boxes share drop out as far as they are white or drift; when they jump, nothing is
learnt from them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_WAYS = 12
"""Hypotheses of one pair."""

LEAST_LOG = -12.0
"""Log weight, relative to the best, below which a hypothesis is dropped."""

TURN = 0.6
"""Change of a robot's course, one sigma after a second, rad/s^0.5."""

DRIFT = 0.1
"""… of the place that the platform's slow errors give both robots, m/s^0.5."""

ODD = 3.0
"""Sigmas of a move that both boxes share from which it is none of the robots'."""

SAME = 0.5
"""Squared Mahalanobis distance up to which two hypotheses have come to the same."""

_PLACES = np.array([0, 1, 4, 5])
_BOTH = np.vstack([np.eye(2), np.eye(2)])


@dataclass(eq=False)
class Pair:
    """Two robots near one another.

    Attributes:
        names: of the first and the second; of tracks that exchange their names, the new ones.
        ways: (k, 8) place and velocity of the first, of the second robot, m, m/s, best first.
        covariances: (k, 8, 8) of these.
        log_weights: (k,).
        signs: (k,) 1.0 where the last image's names are right, -1.0 where they are exchanged.
        seen_ns: stamp of the last image that showed both, ns.
    """

    names: tuple[str, str]
    ways: Array
    covariances: Array
    log_weights: Array
    signs: Array
    seen_ns: int

    @classmethod
    def begin(
        cls, names: tuple[str, str], places: Array, velocities: Array, spread: Array, stamp_ns: int
    ) -> Pair:
        """Return a pair whose names are certain.

        Args:
            names: of the two.
            places: (2, 2) East, North, m.
            velocities: (2, 2) m/s.
            spread: (2, 4, 4) covariance of places and velocities.
            stamp_ns: of the image, ns.
        """
        covariance = np.zeros((1, 8, 8))
        covariance[0, :4, :4], covariance[0, 4:, 4:] = spread
        way = np.concatenate([places, velocities], axis=1).reshape(1, 8)
        return cls(names, way, covariance, np.zeros(1), np.ones(1), stamp_ns)

    @property
    def exchanged(self) -> float:
        """Probability that the two names are exchanged."""
        weights = np.exp(self.log_weights)
        return float(weights[self.signs < 0.0].sum() / weights.sum())

    def exchange(self) -> None:
        """Take the names, or the last image's boxes, the other way round."""
        self.signs = -self.signs

    def step(
        self, stamp_ns: int, places: Array, own: Array, common: Array, acceleration: float
    ) -> float:
        """Take in the two boxes of one image.

        Returns:
            Probability that they are exchanged against those of the image before.

        Args:
            stamp_ns: of the image, ns.
            places: (2, 2) of the boxes of the ones that bear the first and the second name, m.
            own: (2, 2, 2) white covariance of each, m².
            common: (2, 2) of the error that they share, m².
            acceleration: of a robot along its course, root of the spectral density, m/s^1.5.
        """
        self._predict((stamp_ns - self.seen_ns) * 1e-9, acceleration)
        self.seen_ns = stamp_ns
        right, turned = places.reshape(4), places[::-1].reshape(4)
        off = np.stack([right - self.ways[:, _PLACES], turned - self.ways[:, _PLACES]])
        spread = self.covariances[:, _PLACES][:, :, _PLACES] + self._noise(off[0, 0], own, common)
        inverse = np.linalg.inv(spread)
        gain = self.covariances[:, :, _PLACES] @ inverse
        left = self.covariances - gain @ self.covariances[:, _PLACES]
        ways = self.ways + np.einsum("kij,skj->ski", gain, off)
        squared = np.einsum("ski,kij,skj->sk", off, inverse, off)
        weights = self.log_weights - 0.5 * (squared + np.linalg.slogdet(spread)[1])
        weights = (weights - weights.max()).reshape(-1)
        k = len(self.ways)
        signs = np.repeat([1.0, -1.0], k)
        share = np.exp(weights)
        other = float(share[signs != np.tile(self.signs, 2)].sum() / share.sum())
        self._keep(ways.reshape(2 * k, 8), np.tile(left, (2, 1, 1)), weights, signs)
        return other

    def _noise(self, off: Array, own: Array, common: Array) -> Array:
        """Return the covariance (4, 4) of both boxes; what moves both at once counts as noise."""
        noise = np.zeros((4, 4))
        noise[:2, :2], noise[2:, 2:] = own
        shared = 0.5 * (off[:2] + off[2:])
        spread = self.covariances[0][np.ix_(_PLACES, _PLACES)] + noise
        expected = 0.25 * _BOTH.T @ spread @ _BOTH + common
        if shared @ np.linalg.solve(expected, shared) > ODD**2:
            common = common + np.outer(shared, shared)
        return noise + _BOTH @ common @ _BOTH.T

    def _predict(self, seconds: float, acceleration: float) -> None:
        move = np.eye(8)
        move[[0, 1, 4, 5], [2, 3, 6, 7]] = seconds
        course = np.array([[seconds**2 / 3.0, seconds / 2.0], [seconds / 2.0, 1.0]]) * seconds
        covariances = move @ self.covariances @ move.T
        for first in (0, 4):
            east, north = self.ways[:, first + 2], self.ways[:, first + 3]
            across = np.stack([-north, east], axis=1)
            kicks = TURN**2 * across[:, :, None] * across[:, None] + acceleration**2 * np.eye(2)
            noise = np.einsum("pq,kij->kpiqj", course, kicks).reshape(-1, 4, 4)
            covariances[:, first : first + 4, first : first + 4] += noise
        drift = DRIFT**2 * seconds * (_BOTH @ _BOTH.T)
        covariances[:, _PLACES[:, None], _PLACES] += drift
        self.ways, self.covariances = self.ways @ move.T, covariances

    def _keep(self, ways: Array, covariances: Array, weights: Array, signs: Array) -> None:
        """Keep the best hypotheses; those that have come to the same go on as one."""
        kept: list[int] = []
        total: list[float] = []
        for i in np.argsort(-weights, kind="stable").tolist():
            if weights[i] < LEAST_LOG:
                break
            rivals = [n for n, j in enumerate(kept) if signs[j] == signs[i]]
            if rivals:
                off = ways[[kept[n] for n in rivals]] - ways[i]
                near = np.einsum("na,na->n", off, np.linalg.solve(covariances[i], off.T).T) < SAME
                if near.any():
                    first = rivals[int(np.argmax(near))]
                    total[first] = float(np.logaddexp(total[first], weights[i]))
                    continue
            if len(kept) < MOST_WAYS:
                kept.append(i)
                total.append(float(weights[i]))
        self.ways, self.covariances, self.signs = ways[kept], covariances[kept], signs[kept]
        self.log_weights = np.array(total)
