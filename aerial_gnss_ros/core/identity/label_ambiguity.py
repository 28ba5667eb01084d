# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names that may be another robot's since an encounter: how likely whose, and what is published.

For each name there is a law over the tracks, by their present names: on which its robot may be. Two
tracks that have exchanged their robots with probability p mix what was known of the two before; so
a robot that met another one and then a third may be on any of three tracks. At the place of its own
track, a name gets the second moment of where its robot may be instead, wherever that track is by
then and however little is known of it: it may be out of sight.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
T = TypeVar("T")


@dataclass(frozen=True)
class LabelAmbiguityTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    least_probability: float = 1e-3
    """Probability of other tracks from which it shows in the covariance; below, it is forgotten.
    Judged."""


TUNING = LabelAmbiguityTuning()


class Position(NamedTuple):
    """Where a track is.

    Attributes:
        place: (2,) East, North, m.
        covariance: (2, 2) of it, m².
    """

    place: Array
    covariance: Array


class LabelAmbiguity:
    """Where the robot of each name may be.

    Attributes:
        probabilities: by name, probability by name of the track; names that are certain are not in
            it.
    """

    def __init__(
        self,
        of: Mapping[str, Mapping[str, float]] | None = None,
        left: Mapping[str, Position] | None = None,
    ) -> None:
        self.probabilities = dict(of or {})
        self._left = dict(left or {})

    def after_exchange(self, one: str, other: str, exchanged: float) -> LabelAmbiguity:
        """Return what is known after two tracks have exchanged their robots with a probability."""
        return self.after_permutation(exchange_probabilities(one, other, exchanged))

    def after_permutation(self, laws: Mapping[str, Mapping[str, float]]) -> LabelAmbiguity:
        """Return what is known after some tracks may have exchanged their robots among them.

        Args:
            laws: by track, the probability of each to go on with its robot; others keep theirs.
        """
        of: dict[str, dict[str, float]] = {}
        for name in (
            *self.probabilities,
            *(track for track in laws if track not in self.probabilities),
        ):
            law: dict[str, float] = {}
            for before, share in self.probabilities.get(name, {name: 1.0}).items():
                for track, chance in laws.get(before, {before: 1.0}).items():
                    law[track] = law.get(track, 0.0) + share * chance
            if law != {name: 1.0}:
                of[name] = law
        return LabelAmbiguity(of, self._left)

    def after_departure(self, name: str, spot: Position, share: float) -> LabelAmbiguity:
        """Return what is known after a robot has stayed at a spot with a probability.

        Args:
            name: of the robot, and of the track that has its name from now on.
            spot: where it may be instead.
            share: how likely.
        """
        place = f"{name} at {spot.place[0]:.1f}, {spot.place[1]:.1f}"  # no track has such a name
        of = self.after_permutation({name: {name: 1.0 - share, place: share}}).probabilities
        return LabelAmbiguity(of, {**self._left, place: spot})

    def prune(self, spots: Mapping[str, Position]) -> None:
        """Forget names without a track, and doubts too small to matter.

        Tracks that end stay where they are in others' laws.

        Args:
            spots: where the track of each name is.
        """
        self.probabilities = {
            name: law
            for name, law in self.probabilities.items()
            if name in spots and 1.0 - law.get(name, 0.0) > TUNING.least_probability
        }
        meant = {track for law in self.probabilities.values() for track in law}
        self._left = {name: spot for name, spot in self._left.items() if name in meant} | {
            name: spots[name] for name in meant if name in spots
        }

    def covariances(self, spots: Mapping[str, Position]) -> dict[str, Array]:
        """Return what is to be added to the covariances (2, 2) of names in doubt, m²."""
        found: dict[str, Array] = {}
        known = {**self._left, **spots}
        for name, law in self.probabilities.items():
            away = {track: p for track, p in law.items() if track != name and track in known}
            if name in spots and sum(away.values()) > TUNING.least_probability:
                apart = np.array([known[track].place - spots[name].place for track in away])
                wider = np.array(
                    [known[track].covariance - spots[name].covariance for track in away]
                )
                weights = np.array(list(away.values()))
                found[name] = np.einsum("k,ka,kb->ab", weights, apart, apart) + _positive(
                    np.einsum("k,kab->ab", weights, wider)
                )
        return found


def exchange_probabilities(one: T, other: T, share: float) -> dict[T, dict[T, float]]:
    """Return the laws (`LabelAmbiguity.mapped`) of two tracks that have exchanged their robots.

    Args:
        one: of the tracks.
        other: of them.
        share: how likely.
    """
    kept = 1.0 - share
    return {one: {one: kept, other: share}, other: {other: kept, one: share}}


def _positive(matrix: Array) -> Array:
    """Return the part of a symmetric matrix that makes a covariance larger."""
    values, vectors = np.linalg.eigh(matrix)
    part: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return part
