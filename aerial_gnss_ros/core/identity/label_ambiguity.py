# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ambiguous labels: the probability that a label's robot is on another track.

Each label has a distribution over tracks, given by the tracks' present labels. Two tracks that may
have exchanged their robots, with probability p, mix their two distributions; so a robot that met
first one robot and then another may be on any of three tracks. The published covariance is the
second moment of that mixture about the label's own track. It uses the present positions of the
other tracks, also of those out of view.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE

Array = NDArray[np.float64]
T = TypeVar("T")


class Position(NamedTuple):
    """Estimated position of a track.

    Attributes:
        place: (2,) East, North, m.
        covariance: (2, 2) of the position, m².
    """

    place: Array
    covariance: Array


class LabelAmbiguity:
    """Distribution over tracks of each label's robot.

    Attributes:
        probabilities: by label, the probability of each track, by its label; unambiguous labels are
            left out.
    """

    def __init__(
        self,
        of: Mapping[str, Mapping[str, float]] | None = None,
        left: Mapping[str, Position] | None = None,
    ) -> None:
        self.probabilities = dict(of or {})
        self._left = dict(left or {})

    def after_exchange(self, one: str, other: str, exchanged: float) -> LabelAmbiguity:
        """Return the distributions after two tracks may have exchanged their robots."""
        return self.after_permutation(exchange_probabilities(one, other, exchanged))

    def after_permutation(self, distributions: Mapping[str, Mapping[str, float]]) -> LabelAmbiguity:
        """Return the distributions after several tracks may have permuted their robots.

        Args:
            distributions: by track, the probability of each track to continue with its robot; other
                tracks are unchanged.
        """
        of: dict[str, dict[str, float]] = {}
        for name in (
            *self.probabilities,
            *(track for track in distributions if track not in self.probabilities),
        ):
            distribution: dict[str, float] = {}
            for before, share in self.probabilities.get(name, {name: 1.0}).items():
                for track, chance in distributions.get(before, {before: 1.0}).items():
                    distribution[track] = distribution.get(track, 0.0) + share * chance
            if distribution != {name: 1.0}:
                of[name] = distribution
        return LabelAmbiguity(of, self._left)

    def after_departure(self, name: str, position: Position, share: float) -> LabelAmbiguity:
        """Return the distributions after a robot may have stayed where it was.

        Args:
            name: label of the robot, and of the track that has it from now on.
            position: where the robot may be instead.
            share: probability of that.
        """
        # No track has such a label.
        place = f"{name} at {position.place[0]:.1f}, {position.place[1]:.1f}"
        of = self.after_permutation({name: {name: 1.0 - share, place: share}}).probabilities
        return LabelAmbiguity(of, {**self._left, place: position})

    def renamed(self, names: Mapping[str, str]) -> LabelAmbiguity:
        """Return the distributions with other labels.

        Args:
            names: new labels by old ones; others stay.
        """
        of = {
            names.get(name, name): {names.get(track, track): p for track, p in tracks.items()}
            for name, tracks in self.probabilities.items()
        }
        return LabelAmbiguity(of, {names.get(name, name): at for name, at in self._left.items()})

    def prune(self, estimates: Mapping[str, Position]) -> None:
        """Forget labels without a track and negligible ambiguities.

        Tracks that ended keep their last position in the distributions of others.

        Args:
            estimates: estimated position of each label's track.
        """
        self.probabilities = {
            name: distribution
            for name, distribution in self.probabilities.items()
            if name in estimates and 1.0 - distribution.get(name, 0.0) > EVIDENCE.forgotten
        }
        used = {track for distribution in self.probabilities.values() for track in distribution}
        self._left = {name: position for name, position in self._left.items() if name in used} | {
            name: estimates[name] for name in used if name in estimates
        }

    def covariances(self, estimates: Mapping[str, Position]) -> dict[str, Array]:
        """Return the covariances (2, 2) to be added for ambiguous labels, m²."""
        found: dict[str, Array] = {}
        known = {**self._left, **estimates}
        for name, distribution in self.probabilities.items():
            others = {
                track: p for track, p in distribution.items() if track != name and track in known
            }
            if name in estimates and sum(others.values()) > EVIDENCE.forgotten:
                apart = np.array([known[track].place - estimates[name].place for track in others])
                differences = np.array(
                    [known[track].covariance - estimates[name].covariance for track in others]
                )
                weights = np.array(list(others.values()))
                found[name] = np.einsum("k,ka,kb->ab", weights, apart, apart) + _positive(
                    np.einsum("k,kab->ab", weights, differences)
                )
        return found


def exchange_probabilities(one: T, other: T, share: float) -> dict[T, dict[T, float]]:
    """Return the permutation distribution of two tracks that may have exchanged robots.

    Args:
        one: of the tracks.
        other: track.
        share: probability of the exchange.
    """
    kept = 1.0 - share
    return {one: {one: kept, other: share}, other: {other: kept, one: share}}


def _positive(matrix: Array) -> Array:
    """Return the positive semidefinite part of a symmetric matrix."""
    values, vectors = np.linalg.eigh(matrix)
    part: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return part
