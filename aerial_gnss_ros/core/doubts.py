# SPDX-License-Identifier: Apache-2.0
"""Names that may be another robot's since an encounter: how likely whose, and what is published.

For each name there is a law over the tracks, by their present names: on which its robot may be. Two
tracks that have exchanged their robots with probability p mix what was known of the two before; so
a robot that met another one and then a third may be on any of three tracks. At the place of its own
track, a name gets the second moment of where its robot may be instead.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST = 1e-3
"""Probability of another track from which it shows in the covariance."""


class Doubts:
    """Where the robot of each name may be.

    Attributes:
        of: by name, probability by name of the track; names that are certain are not in it.
    """

    def __init__(self, of: Mapping[str, Mapping[str, float]] | None = None) -> None:
        self.of = dict(of or {})
        self._left: dict[str, Array] = {}

    def mixed(self, one: str, other: str, exchanged: float) -> Doubts:
        """Return what is known after two tracks have exchanged their robots with a probability."""
        kept = 1.0 - exchanged
        return self.mapped(
            {one: {one: kept, other: exchanged}, other: {other: kept, one: exchanged}}
        )

    def mapped(self, laws: Mapping[str, Mapping[str, float]]) -> Doubts:
        """Return what is known after some tracks may have exchanged their robots among them.

        Args:
            laws: by track, the probability of each to go on with its robot; others keep theirs.
        """
        of: dict[str, dict[str, float]] = {}
        for name in (*self.of, *(track for track in laws if track not in self.of)):
            law: dict[str, float] = {}
            for before, share in self.of.get(name, {name: 1.0}).items():
                for track, chance in laws.get(before, {before: 1.0}).items():
                    law[track] = law.get(track, 0.0) + share * chance
            if law != {name: 1.0}:
                of[name] = law
        found = Doubts(of)
        found._left = self._left
        return found

    def keep(self, places: Mapping[str, Array]) -> None:
        """Forget names without a track; tracks that end stay where they are in others' laws.

        Args:
            places: (2,) East, North of the track of each name, m.
        """
        self.of = {name: law for name, law in self.of.items() if name in places}
        meant = {track for law in self.of.values() for track in law}
        self._left = {name: place for name, place in self._left.items() if name in meant} | {
            name: places[name] for name in meant if name in places
        }

    def covariances(self, places: Mapping[str, Array]) -> dict[str, Array]:
        """Return what is to be added to the covariances (2, 2) of names in doubt, m²."""
        found: dict[str, Array] = {}
        known = {**self._left, **places}
        for name, law in self.of.items():
            away = {track: p for track, p in law.items() if track != name and track in known}
            if name in places and sum(away.values()) > LEAST:
                apart = np.array([known[track] - places[name] for track in away])
                weights = np.array(list(away.values()))
                found[name] = np.einsum("k,ka,kb->ab", weights, apart, apart)
        return found
