# SPDX-License-Identifier: Apache-2.0
"""Robots that pass so close that one image cannot tell them apart: the decision is deferred.

Two boxes near one another are taken for one robot each by the best guess, image by image. What is
uncertain is only which is which, that is the sign of the vector between the two. So while a pair is
close, the likeliest ways of that vector are followed side by side (multiple hypotheses: Reid 1979;
Blackman 2004), each with its own signs; the platform's errors are the same for both boxes and drop
out. When the pair has parted, what came before and after speaks for one of the ways, and names that
the guesses exchanged are put right. Until then the published covariance contains the doubt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.track import Track

Array = NDArray[np.float64]

NEAR = 8.0
"""Distance, in one sigma of the vector between two boxes, from which a pair is followed."""

PARTED = 12.0
"""… and from which it no longer is."""

MOST_PAIRS = 30
"""Pairs followed at once; the nearest come first."""

MOST_WAYS = 12
"""Hypotheses of one pair."""

LEAST_LOG = -12.0
"""Log weight, relative to the best, below which a hypothesis is dropped."""

STEERING = 4.0
"""Robots that meet steer: their acceleration as a multiple of the stated one."""

LEAST_ACCELERATION = 0.02
"""m/s^1.5."""

FIRST_SPEED = 0.3
"""One sigma of the relative velocity at first, each axis, m/s."""

SURE = 0.95
"""Probability from which names are exchanged."""

APART = 3.0
"""… where the boxes are so many sigma apart."""

LEAST_DOUBT = 1e-3
"""Probability from which it shows in the covariance."""

LOST_S = 3.0
"""A pair that no image has shown together for so long is given up."""


@dataclass
class Pair:
    """The vector between two robots, by several hypotheses of who is who.

    Attributes:
        ways: (k, 4) vector and its rate, m, m/s, the best first.
        log_weights: (k,).
        signs: (k,) 1.0 where the last image's names are right, -1.0 where they are exchanged.
        covariance: (4, 4) the same for all.
        seen_ns: stamp of the last image that showed both, ns.
        apart: (2,) the vector between the boxes then, m.
    """

    ways: Array
    log_weights: Array
    signs: Array
    covariance: Array
    seen_ns: int
    apart: Array

    @property
    def exchanged(self) -> float:
        """Probability that the two names are exchanged."""
        weights = np.exp(self.log_weights)
        return float(weights[self.signs < 0.0].sum() / weights.sum())

    def exchange(self) -> None:
        """Take the names the other way round."""
        self.signs, self.apart = -self.signs, -self.apart

    def step(self, stamp_ns: int, apart: Array, white: Array, acceleration: float) -> None:
        """Take in the vector between the boxes in one image.

        Args:
            stamp_ns: of the image, ns.
            apart: (2,) from the one that bears the first name to the other, m.
            white: (2, 2) covariance of it, m².
            acceleration: root of its spectral density, m/s^1.5.
        """
        self._predict((stamp_ns - self.seen_ns) * 1e-9, acceleration)
        self.seen_ns, self.apart = stamp_ns, apart
        spread = self.covariance[:2, :2] + white
        inverse = np.linalg.inv(spread)
        gain = self.covariance[:, :2] @ inverse
        self.covariance = self.covariance - gain @ self.covariance[:2]
        k = len(self.ways)
        signs = np.repeat([1.0, -1.0], k)
        ways = np.vstack([self.ways, self.ways])
        off = signs[:, None] * apart - ways[:, :2]
        ways = ways + off @ gain.T
        weights = np.tile(self.log_weights, 2) - 0.5 * np.einsum("ia,ab,ib->i", off, inverse, off)
        self._keep(ways, weights - weights.max(), signs)

    def _predict(self, seconds: float, acceleration: float) -> None:
        move = np.eye(4)
        move[:2, 2:] = seconds * np.eye(2)
        q = acceleration**2 * seconds
        noise = np.array([[seconds**2 / 3.0, seconds / 2.0], [seconds / 2.0, 1.0]])
        self.ways = self.ways @ move.T
        self.covariance = move @ self.covariance @ move.T + q * np.kron(noise, np.eye(2))

    def _keep(self, ways: Array, weights: Array, signs: Array) -> None:
        """Keep the best hypotheses; those that have come to the same go on as one."""
        precision = np.linalg.inv(self.covariance)
        kept: list[int] = []
        total: list[float] = []
        for i in np.argsort(-weights, kind="stable"):
            if weights[i] < LEAST_LOG:
                break
            off = ways[kept] - ways[i]
            same = np.einsum("ia,ab,ib->i", off, precision, off) < 0.5
            same &= signs[kept] == signs[i]
            if same.any():
                first = int(np.argmax(same))
                total[first] = float(np.logaddexp(total[first], weights[i]))
            elif len(kept) < MOST_WAYS:
                kept.append(int(i))
                total.append(float(weights[i]))
        self.ways, self.signs = ways[kept], signs[kept]
        self.log_weights = np.array(total)


class Encounters:
    """Follows pairs of named robots that are close.

    Args:
        acceleration: of a robot, root of the spectral density, m/s^1.5.
    """

    def __init__(self, acceleration: float) -> None:
        self._acceleration = max(np.sqrt(2.0) * STEERING * acceleration, LEAST_ACCELERATION)
        self._pairs: dict[tuple[str, str], Pair] = {}

    def reset(self) -> None:
        """Forget all pairs."""
        self._pairs.clear()

    def take(self, tracks: list[Track], positions: Array, white: Array, stamp_ns: int) -> None:
        """Take in the boxes of the named robots of one image; put exchanged names right.

        Args:
            tracks: m that the image shows, as the association has it; names may be exchanged.
            positions: (m, 2) of their boxes, East, North, m.
            white: (m, 2, 2) white covariance of these, m².
            stamp_ns: of the image, ns.
        """
        shown = {track.robot_id: i for i, track in enumerate(tracks)}
        for names in list(self._pairs):
            pair = self._pairs[names]
            if names[0] in shown and names[1] in shown:
                a, b = shown[names[0]], shown[names[1]]
                apart, spread = positions[b] - positions[a], white[a] + white[b]
                pair.step(stamp_ns, apart, spread, self._acceleration)
                away = float(apart @ np.linalg.solve(spread, apart))
                if away > PARTED**2 and not 1.0 - SURE < pair.exchanged < SURE:
                    del self._pairs[names]
                if pair.exchanged > SURE and away > APART**2:
                    tracks[a].exchange(tracks[b])
                    shown[names[0]], shown[names[1]] = b, a
                    pair.exchange()
            elif stamp_ns - pair.seen_ns > LOST_S * 1e9:
                del self._pairs[names]
        self._begin(tracks, positions, white, stamp_ns)

    def doubts(self) -> dict[str, Array]:
        """Return covariances (2, 2) to be added for names that may be another's, m²."""
        found: dict[str, Array] = {}
        for names, pair in self._pairs.items():
            if pair.exchanged > LEAST_DOUBT:
                doubt = pair.exchanged * np.outer(pair.apart, pair.apart)
                for name in names:
                    found[name] = found.get(name, np.zeros((2, 2))) + doubt
        return found

    def _begin(self, tracks: list[Track], positions: Array, white: Array, stamp_ns: int) -> None:
        """Follow pairs that have come close."""
        if len(tracks) < 2:
            return
        size = np.sqrt(np.trace(white, axis1=1, axis2=2))
        apart = np.hypot(*(positions[:, None] - positions[None]).transpose(2, 0, 1))
        near = np.triu(apart < NEAR * np.maximum(size[:, None], size[None]), 1)
        rows, columns = np.nonzero(near)
        for i in np.argsort(apart[rows, columns], kind="stable"):
            if len(self._pairs) >= MOST_PAIRS:
                return
            a, b = int(rows[i]), int(columns[i])
            one, other = tracks[a], tracks[b]
            names = (one.robot_id, other.robot_id)
            if one.class_id != other.class_id or names in self._pairs or names[::-1] in self._pairs:
                continue
            vector = positions[b] - positions[a]
            covariance = np.zeros((4, 4))
            covariance[:2, :2] = white[a] + white[b]
            covariance[2:, 2:] = FIRST_SPEED**2 * np.eye(2)
            way = np.concatenate([vector, other.velocity - one.velocity])[None]
            self._pairs[names] = Pair(way, np.zeros(1), np.ones(1), covariance, stamp_ns, vector)
