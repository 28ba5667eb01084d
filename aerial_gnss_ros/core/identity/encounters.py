# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that pass so close that one image cannot tell them apart: the decision is deferred.

Two boxes near one another are taken for one robot each by the best guess, image by image. What is
uncertain is only which is which. So while a pair is close, the likeliest ways of the two are
followed side by side (`pair_hypotheses`; multiple hypotheses: Reid 1979; Blackman 2004). They say
which box goes on with which track and, when what came before and after speaks for it, that names
were exchanged: these are put right. Whatever is still open when the pair has parted is kept, and
the published covariance contains it (`label_ambiguity`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity.label_ambiguity import LabelAmbiguity, Position
from aerial_gnss_ros.core.identity.pair_hypotheses import PairHypotheses
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class EncountersTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    followed_sigmas: float = 8.0
    """Distance, in one sigma of the vector between two boxes, from which a pair is followed.
    Judged."""
    parted_sigmas: float = 12.0
    """The same distance from which it is followed no longer. Judged."""
    most_pairs: int = 30
    """Pairs followed at once; the nearest come first. Judged."""
    steering_ratio: float = 2.0
    """Robots that meet speed up and slow down: as a multiple of the stated acceleration. Judged."""
    least_acceleration: float = 0.02
    """Least spectral density of the acceleration of robots that meet, root, m/s^1.5. Judged."""
    velocity_lag_mps: float = 0.1
    """A robot that turns is slower in the filter to change its velocity: one sigma, each axis, m/s.
    Judged."""
    exchange_probability: float = 0.9
    """Probability from which names are exchanged while a pair is together: not at each turn of the
    scales, for each exchange is a change of names, and until it has parted the published
    covariances hold both robots. Then the likelier way is taken. Judged."""
    lost_s: float = 3.0
    """A pair that no image has shown together for so long has parted. Judged."""
    remembered_probability: float = 0.01
    """Probability that two names are exchanged from which it is remembered when the pair has
    parted. Judged."""


TUNING = EncountersTuning()


class Known(Protocol):
    """What is known of the robots near one another: the joint filter."""

    @property
    def motion(self) -> MotionModel:
        """How robots move."""

    @property
    def covariance(self) -> Array:
        """(n, 4, 4) of robots' places and velocities."""

    def box_noise(self, places: Array) -> Array:
        """Return the covariances (m, 2, 2) of places on the water from boxes' own noise, m²."""


@lru_cache(maxsize=8)
def _every_pair(n: int) -> tuple[Indices, Indices]:
    """Return the first and the second of each two of n, by the first."""
    rows, columns = np.triu_indices(n, 1)
    return rows, columns


def _close(positions: Array, white: Array) -> list[list[int]]:
    """Return which two boxes are so close that they are followed, the closest first.

    Args:
        positions: (n, 2) East, North, m.
        white: (n, 2, 2) covariances of these, m².
    """
    size = np.sqrt(white[:, 0, 0] + white[:, 1, 1])
    if len(size) <= MAX_ROWS:
        boxes = list(enumerate(zip(positions.tolist(), size.tolist(), strict=True)))
        found = []
        for (a, ((east, north), own)), (b, ((x, y), theirs)) in combinations(boxes, 2):
            apart = math.hypot(east - x, north - y)
            if apart < TUNING.followed_sigmas * max(own, theirs):
                found.append((apart, a, b))
        return [[a, b] for _, a, b in sorted(found)]
    firsts, seconds = _every_pair(len(size))
    vectors = positions[firsts] - positions[seconds]
    distances = np.hypot(vectors[:, 0], vectors[:, 1])
    near = distances < TUNING.followed_sigmas * np.maximum(size[firsts], size[seconds])
    order = np.argsort(distances[near], kind="stable")
    pairs: list[list[int]] = np.stack([firsts[near], seconds[near]], axis=1)[order].tolist()
    return pairs


class Encounters:
    """Follows pairs of named robots that are close.

    Args:
        known: the filter that has the robots.
    """

    def __init__(self, known: Known) -> None:
        self._known = known
        self._acceleration = max(
            TUNING.steering_ratio * known.motion.acceleration, TUNING.least_acceleration
        )
        self._pairs: list[PairHypotheses] = []
        self._parted = LabelAmbiguity()

    def reset(self) -> None:
        """Forget all pairs and doubts."""
        self._pairs.clear()
        self._parted = LabelAmbiguity()

    def update(
        self, tracks: list[Track], rows: Indices, positions: Array, white: Array, stamp_ns: int
    ) -> Indices:
        """Take in the boxes of the named robots of one image; put exchanged names right.

        Args:
            tracks: m that the image shows, as the association has it; names may be exchanged.
            rows: (m,) theirs in the filter.
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
                both = [one, other]
                apart, spread = positions[other] - positions[one], white[one] + white[other]
                own = self._known.box_noise(positions[both])
                common = (white[both] - own).mean(axis=0)
                if pair.update(stamp_ns, positions[both], own, common, self._acceleration) > 0.5:
                    boxes[a], boxes[b] = other, one
                    pair.exchange()
                parted = float(apart @ np.linalg.solve(spread, apart)) > TUNING.parted_sigmas**2
                if pair.exchanged > (0.5 if parted else TUNING.exchange_probability):
                    tracks[a].swap_labels(tracks[b])
                    shown[pair.names[0]], shown[pair.names[1]] = b, a
                    self._exchange(pair)
                if parted:
                    self._part(pair)
            elif stamp_ns - pair.seen_ns > TUNING.lost_s * 1e9:
                self._part(pair)
        self._begin(tracks, rows, positions[boxes], white[boxes], stamp_ns)
        return boxes

    def update_ambiguity(self, laws: Mapping[str, Mapping[str, float]]) -> None:
        """Take in which robot may be on which track, by label (`LabelAmbiguity.mapped`)."""
        self._parted = self._parted.after_permutation(laws)

    def note_departure(self, name: str, spot: Position, share: float) -> None:
        """Take in that a name's robot may have stayed at a spot, by this probability."""
        self._parted = self._parted.after_departure(name, spot, share)

    @property
    def ambiguous(self) -> bool:
        """Whether there are names that may be another's."""
        return bool(self._pairs or self._parted.probabilities)

    def ambiguity_covariances(self, spots: dict[str, Position]) -> dict[str, Array]:
        """Return covariances (2, 2) to be added for names that may be another's, m².

        Args:
            spots: where each named robot is; names that lack are forgotten.
        """
        self._parted.prune(spots)
        now = self._parted
        for pair in self._pairs:
            if pair.names[0] in spots and pair.names[1] in spots:
                now = now.after_exchange(*pair.names, pair.exchanged)
        return now.covariances(spots)

    def _exchange(self, decided: PairHypotheses) -> None:
        """Let all other pairs follow the same tracks as before, under exchanged names."""
        decided.exchange()
        other = dict(zip(decided.names, decided.names[::-1], strict=True))
        for pair in self._pairs:
            if pair is not decided:
                first, second = pair.names
                pair.names = other.get(first, first), other.get(second, second)

    def _part(self, pair: PairHypotheses) -> None:
        self._pairs.remove(pair)
        if pair.exchanged > TUNING.remembered_probability:
            self._parted = self._parted.after_exchange(*pair.names, pair.exchanged)

    def _begin(
        self, tracks: list[Track], rows: Indices, positions: Array, white: Array, stamp_ns: int
    ) -> None:
        """Follow pairs that have come close."""
        if len(tracks) < 2:
            return
        close = _close(positions, white)
        followed = [{*pair.names} for pair in self._pairs]
        for both in close:
            if len(self._pairs) >= TUNING.most_pairs:
                return
            one, other = (tracks[k] for k in both)
            names = (one.robot_id, other.robot_id)
            if one.class_id != other.class_id or {*names} in followed:
                continue
            spread = np.zeros((2, 4, 4))
            spread[:, :2, :2] = white[both]
            spread[:, 2:, 2:] = self._known.covariance[
                rows[both], 2:, 2:
            ] + TUNING.velocity_lag_mps**2 * np.eye(2)
            velocities = np.array([one.velocity, other.velocity])
            self._pairs.append(
                PairHypotheses.begin(names, positions[both], velocities, spread, stamp_ns)
            )
