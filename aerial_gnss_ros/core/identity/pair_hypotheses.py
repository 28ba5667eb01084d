# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two robots that are close: their ways, by several hypotheses of which box is whose.

Each image doubles the hypotheses: its two boxes may be one way round or the other. They are judged
by how robots swim: a robot that meets another one turns, but hardly changes its speed, and it goes
on turning for a while. So its acceleration is that of `noise.robot_acceleration`, a few times, and
across its course there is a rate of turn with a memory (the coordinated turn: Bar-Shalom, Li,
Kirubarajan 2001, 11.7) and `TUNING.course_density` besides. Whether two robots that came within a
hull's length crossed or turned away from one another is told by their speeds, courses and rates of
turn before and after, all at once.

Errors that both boxes share drop out as far as they are white or drift; when they jump, nothing is
learnt from them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PairHypothesesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_ways: int = 12
    """Hypotheses of one pair. Judged."""
    least_log: float = -12.0
    """Log weight, relative to the best, below which a hypothesis is dropped. Judged."""
    turn_rate_sigma: float = 0.5
    """A robot's rate of turn, one sigma, rad/s. Chosen by the log likelihood of the right
    ways in `benchmarks/meetings.py --seeds 120 --first 500`."""
    turn_lasts_s: float = 1.5
    """How long a turn lasts, s. Chosen in the same way."""
    course_density: float = 0.2
    """Change of its course that has no memory, one sigma after a second, rad/s^0.5. Judged."""
    place_density: float = 0.1
    """The same of the place that the platform's slow errors give both robots, m/s^0.5. Judged."""
    odd_sigmas: float = 3.0
    """Sigmas of a move that both boxes share from which it is none of the robots'. Judged."""
    same_squared: float = 0.5
    """Squared Mahalanobis distance up to which two hypotheses have come to the same. Judged."""


TUNING = PairHypothesesTuning()


_PLACES = np.array([0, 1, 4, 5])
_BOTH = np.vstack([np.eye(2), np.eye(2)])


@dataclass(eq=False)
class PairHypotheses:
    """Two robots near one another.

    Attributes:
        names: of the first and the second; of tracks that exchange their names, the new ones.
        ways: (k, 10) place and velocity of the first, of the second robot, m, m/s; their rates of
            turn, rad/s; best first.
        covariances: (k, 10, 10) of these.
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
    ) -> PairHypotheses:
        """Return a pair whose names are certain.

        Args:
            names: of the two.
            places: (2, 2) East, North, m.
            velocities: (2, 2) m/s.
            spread: (2, 4, 4) covariance of places and velocities.
            stamp_ns: of the image, ns.
        """
        covariance = np.zeros((1, 10, 10))
        covariance[0, :4, :4], covariance[0, 4:8, 4:8] = spread
        covariance[0, 8:, 8:] = TUNING.turn_rate_sigma**2 * np.eye(2)
        way = np.zeros((1, 10))
        way[0, :8] = np.concatenate([places, velocities], axis=1).reshape(8)
        return cls(names, way, covariance, np.zeros(1), np.ones(1), stamp_ns)

    @property
    def exchanged(self) -> float:
        """Probability that the two names are exchanged."""
        weights = np.exp(self.log_weights)
        return float(weights[self.signs < 0.0].sum() / weights.sum())

    def exchange(self) -> None:
        """Take the names, or the last image's boxes, the other way round."""
        self.signs = -self.signs

    def update(
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
        self._keep(ways.reshape(2 * k, 10), np.tile(left, (2, 1, 1)), weights, signs)
        return other

    def _noise(self, off: Array, own: Array, common: Array) -> Array:
        """Return the covariance (4, 4) of both boxes; what moves both at once counts as noise."""
        noise = np.zeros((4, 4))
        noise[:2, :2], noise[2:, 2:] = own
        shared = 0.5 * (off[:2] + off[2:])
        spread = self.covariances[0][np.ix_(_PLACES, _PLACES)] + noise
        expected = 0.25 * _BOTH.T @ spread @ _BOTH + common
        if shared @ np.linalg.solve(expected, shared) > TUNING.odd_sigmas**2:
            common = common + np.outer(shared, shared)
        return noise + _BOTH @ common @ _BOTH.T

    def _predict(self, seconds: float, acceleration: float) -> None:
        ways, k = self.ways.copy(), len(self.ways)
        move, noise = np.tile(np.eye(10), (k, 1, 1)), np.zeros((k, 10, 10))
        course = np.array([[seconds**2 / 3.0, seconds / 2.0], [seconds / 2.0, 1.0]]) * seconds
        kept = np.exp(-seconds / TUNING.turn_lasts_s)
        for first, turn in ((0, 8), (4, 9)):
            place, swims = slice(first, first + 2), slice(first + 2, first + 4)
            turned = _turned(seconds * ways[:, turn])
            after = np.einsum("kij,kj->ki", turned, ways[:, swims])
            across = np.stack([-after[:, 1], after[:, 0]], axis=1)
            ways[:, place] += 0.5 * seconds * (ways[:, swims] + after)
            ways[:, swims] = after
            ways[:, turn] *= kept
            move[:, place, swims] = 0.5 * seconds * (np.eye(2) + turned)
            move[:, swims, swims] = turned
            move[:, place, turn] = 0.5 * seconds**2 * across
            move[:, swims, turn] = seconds * across
            move[:, turn, turn] = kept
            kicks = TUNING.course_density**2 * across[:, :, None] * across[
                :, None
            ] + acceleration**2 * np.eye(2)
            both = np.einsum("pq,kij->kpiqj", course, kicks).reshape(-1, 4, 4)
            noise[:, first : first + 4, first : first + 4] = both
            noise[:, turn, turn] = TUNING.turn_rate_sigma**2 * (1.0 - kept**2)
        covariances = move @ self.covariances @ move.transpose(0, 2, 1) + noise
        covariances[:, _PLACES[:, None], _PLACES] += (
            TUNING.place_density**2 * seconds * (_BOTH @ _BOTH.T)
        )
        self.ways, self.covariances = ways, covariances

    def _keep(self, ways: Array, covariances: Array, weights: Array, signs: Array) -> None:
        """Keep the best hypotheses; those that have come to the same go on as one."""
        kept: list[int] = []
        total: list[float] = []
        for i in np.argsort(-weights, kind="stable").tolist():
            if weights[i] < TUNING.least_log:
                break
            rivals = [n for n, j in enumerate(kept) if signs[j] == signs[i]]
            if rivals:
                off = ways[[kept[n] for n in rivals]] - ways[i]
                near = (
                    np.einsum("na,na->n", off, np.linalg.solve(covariances[i], off.T).T)
                    < TUNING.same_squared
                )
                if near.any():
                    first = rivals[int(np.argmax(near))]
                    total[first] = float(np.logaddexp(total[first], weights[i]))
                    continue
            if len(kept) < TUNING.most_ways:
                kept.append(i)
                total.append(float(weights[i]))
        self.ways, self.covariances, self.signs = ways[kept], covariances[kept], signs[kept]
        self.log_weights = np.array(total)


def _turned(angles: Array) -> Array:
    """Return matrices (k, 2, 2) that turn by angles (k,), rad."""
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([c, -s, s, c], axis=1).reshape(-1, 2, 2)
