# SPDX-License-Identifier: Apache-2.0
"""Robots that pass so close that one image cannot tell them apart: the decision is deferred.

Two boxes near one another are taken for one robot each by the best guess, image by image. What is
uncertain is only which is which, that is the sign of the vector between the two. So while a pair is
close, the likeliest ways of that vector are followed side by side (multiple hypotheses: Reid 1979;
Blackman 2004), each with its own signs; the platform's errors are the same for both boxes and drop
out. They say which box goes on with which track and, when what came before and after speaks for it,
that names were exchanged: these are put right. Whatever is still open when the pair has parted is
kept, and the published covariance contains it (`doubts`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.doubts import Doubts
from aerial_gnss_ros.core.track import Track

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

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

LIKELY = 2.0 / 3.0
"""Probability from which names are exchanged while a pair is together: not at each turn of the
scales. When it has parted, the likelier way is taken."""

LOST_S = 3.0
"""A pair that no image has shown together for so long has parted."""

KEPT = 0.01
"""Probability that two names are exchanged from which it is remembered when the pair has parted."""


@dataclass(eq=False)
class Pair:
    """The vector between two robots, by several hypotheses of who is who.

    Attributes:
        names: of the first and the second; of tracks that exchange their names, the new ones.
        ways: (k, 4) vector and its rate, m, m/s, the best first.
        log_weights: (k,).
        signs: (k,) 1.0 where the last image's names are right, -1.0 where they are exchanged.
        covariance: (4, 4) the same for all.
        seen_ns: stamp of the last image that showed both, ns.
    """

    names: tuple[str, str]
    ways: Array
    log_weights: Array
    signs: Array
    covariance: Array
    seen_ns: int

    @property
    def exchanged(self) -> float:
        """Probability that the two names are exchanged."""
        weights = np.exp(self.log_weights)
        return float(weights[self.signs < 0.0].sum() / weights.sum())

    def exchange(self) -> None:
        """Take the names, or the last image's boxes, the other way round."""
        self.signs = -self.signs

    def step(self, stamp_ns: int, apart: Array, white: Array, acceleration: float) -> float:
        """Take in the vector between the boxes in one image.

        Returns:
            Probability that its two boxes are exchanged against those of the image before.

        Args:
            stamp_ns: of the image, ns.
            apart: (2,) from the box of the one that bears the first name to the other's, m.
            white: (2, 2) covariance of it, m².
            acceleration: root of its spectral density, m/s^1.5.
        """
        self._predict((stamp_ns - self.seen_ns) * 1e-9, acceleration)
        self.seen_ns = stamp_ns
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
        weights -= weights.max()
        turned = np.exp(weights) * (signs != np.tile(self.signs, 2))
        self._keep(ways, weights, signs)
        return float(turned.sum() / np.exp(weights).sum())

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


@lru_cache(maxsize=8)
def _every_pair(n: int) -> tuple[Indices, Indices]:
    """Return the first and the second of each two of n, by the first."""
    rows, columns = np.triu_indices(n, 1)
    return rows, columns


class Encounters:
    """Follows pairs of named robots that are close.

    Args:
        acceleration: of a robot, root of the spectral density, m/s^1.5.
    """

    def __init__(self, acceleration: float) -> None:
        self._acceleration = max(np.sqrt(2.0) * STEERING * acceleration, LEAST_ACCELERATION)
        self._pairs: list[Pair] = []
        self._parted = Doubts()

    def reset(self) -> None:
        """Forget all pairs and doubts."""
        self._pairs.clear()
        self._parted = Doubts()

    def take(self, tracks: list[Track], positions: Array, white: Array, stamp_ns: int) -> Indices:
        """Take in the boxes of the named robots of one image; put exchanged names right.

        Args:
            tracks: m that the image shows, as the association has it; names may be exchanged.
            positions: (m, 2) of their boxes, East, North, m.
            white: (m, 2, 2) white covariance of these, m².
            stamp_ns: of the image, ns.

        Returns:
            The boxes (m,) that go on with the tracks: 0 to m - 1, exchanged where they were.
        """
        shown = {track.robot_id: i for i, track in enumerate(tracks)}
        boxes = np.arange(len(tracks))
        for pair in list(self._pairs):
            if pair.names[0] in shown and pair.names[1] in shown:
                a, b = (shown[name] for name in pair.names)
                one, other = boxes[a], boxes[b]
                apart, spread = positions[other] - positions[one], white[one] + white[other]
                if pair.step(stamp_ns, apart, spread, self._acceleration) > 0.5:
                    boxes[a], boxes[b] = other, one
                    pair.exchange()
                parted = float(apart @ np.linalg.solve(spread, apart)) > PARTED**2
                if pair.exchanged > (0.5 if parted else LIKELY):
                    tracks[a].exchange(tracks[b])
                    shown[pair.names[0]], shown[pair.names[1]] = b, a
                    self._exchange(pair)
                if parted:
                    self._part(pair)
            elif stamp_ns - pair.seen_ns > LOST_S * 1e9:
                self._part(pair)
        self._begin(tracks, positions[boxes], white[boxes], stamp_ns)
        return boxes

    def doubt(self, one: str, other: str, exchanged: float) -> None:
        """Take in that the robots of two names may be exchanged, by this probability."""
        self._parted = self._parted.mixed(one, other, exchanged)

    def doubts(self, places: dict[str, Array]) -> dict[str, Array]:
        """Return covariances (2, 2) to be added for names that may be another's, m².

        Args:
            places: (2,) East, North where each named robot is, m; names that lack are forgotten.
        """
        self._parted.keep(places)
        now = self._parted
        for pair in self._pairs:
            if pair.names[0] in places and pair.names[1] in places:
                now = now.mixed(*pair.names, pair.exchanged)
        return now.covariances(places)

    def _exchange(self, decided: Pair) -> None:
        """Let all other pairs follow the same tracks as before, under exchanged names."""
        decided.exchange()
        other = dict(zip(decided.names, decided.names[::-1], strict=True))
        for pair in self._pairs:
            if pair is not decided:
                first, second = pair.names
                pair.names = other.get(first, first), other.get(second, second)

    def _part(self, pair: Pair) -> None:
        self._pairs.remove(pair)
        if pair.exchanged > KEPT:
            self._parted = self._parted.mixed(*pair.names, pair.exchanged)

    def _begin(self, tracks: list[Track], positions: Array, white: Array, stamp_ns: int) -> None:
        """Follow pairs that have come close."""
        if len(tracks) < 2:
            return
        rows, columns = _every_pair(len(tracks))
        size = np.sqrt(white[:, 0, 0] + white[:, 1, 1])
        vectors = positions[rows] - positions[columns]
        apart = np.hypot(vectors[:, 0], vectors[:, 1])
        near = apart < NEAR * np.maximum(size[rows], size[columns])
        if not near.any():
            return
        rows, columns, apart = rows[near], columns[near], apart[near]
        followed = [{*pair.names} for pair in self._pairs]
        for i in np.argsort(apart, kind="stable"):
            if len(self._pairs) >= MOST_PAIRS:
                return
            a, b = int(rows[i]), int(columns[i])
            one, other = tracks[a], tracks[b]
            names = (one.robot_id, other.robot_id)
            if one.class_id != other.class_id or {*names} in followed:
                continue
            vector = positions[b] - positions[a]
            covariance = np.zeros((4, 4))
            covariance[:2, :2] = white[a] + white[b]
            covariance[2:, 2:] = FIRST_SPEED**2 * np.eye(2)
            way = np.concatenate([vector, other.velocity - one.velocity])[None]
            self._pairs.append(Pair(names, way, np.zeros(1), np.ones(1), covariance, stamp_ns))
