# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Test of whether a track has moved, relative to a reference that stays.

The distance between track and reference contains the receiver's offset, so it may change as that
offset drifts, by the errors of the boxes, and by the covariance of the reference; a larger change
is motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, NamedTrack
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.source import Source

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StationarityTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    apparent_m: float = 0.3
    """Apparent motion of what stays, by errors of its boxes, one sigma, m. Judged."""
    gate_sigmas: float = 3.0
    """A track that has moved by more is not what stays. Judged."""


TUNING = StationarityTuning()


@dataclass(frozen=True)
class _FirstSeen:
    """A track relative to a reference when both were first compared.

    Attributes:
        apart: (2,) from track to reference, m.
        variance: of the track's position beyond a receiver's offset, m².
        receivers: (2 N,) variances of the receivers' offsets, m².
        stamp_ns: of that image, ns.
    """

    apart: Array
    variance: float
    receivers: Array
    stamp_ns: int


class StationarityTest:
    """Excludes the tracks that have moved since they were first compared with a reference.

    Args:
        source: what is estimated without references.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._first: dict[tuple[str, str], _FirstSeen] = {}
        self._moved: set[tuple[str, str]] = set()
        self._accepted_jumps = np.zeros(2)

    def forget(self, name: str) -> None:
        """Restart the test of a reference whose position has changed."""
        self._first = {pair: one for pair, one in self._first.items() if pair[0] != name}
        self._moved = {pair for pair in self._moved if pair[0] != name}

    def restart(self) -> None:
        """Compare from now on: another calibration has moved the tracks."""
        self._first.clear()

    def update(
        self, one: Candidate, tracks: Sequence[NamedTrack], law: PositionLaw, stamp_ns: int
    ) -> tuple[Candidate, dict[str, float]]:
        """Return a reference without tracks that have moved, and by how much each newly did, m.

        Args:
            one: a reference that stays.
            tracks: by row of the filter.
            law: of the tracks that it may be.
            stamp_ns: of the image, ns.
        """
        believed = self._source.believed
        if not np.array_equal(self._accepted_jumps, believed):
            self._accepted_jumps = believed.copy()
            self._first.clear()
        inside, kept, moved = law.rows.tolist(), list[int](), dict[str, float]()
        for row in one.rows:
            pair = one.name, tracks[row].robot_id
            if row not in inside or pair in self._moved:
                continue
            now = _compared(one, law, row, stamp_ns)
            first = self._first.setdefault(pair, now)
            distance = math.dist(now.apart, first.apart)
            if distance**2 > TUNING.gate_sigmas**2 * self._variance(one, first, now):
                self._moved.add(pair)
                moved[pair[1]] = distance
            else:
                kept.append(row)
        return replace(one, rows=tuple(kept)), moved

    def _variance(self, one: Candidate, first: _FirstSeen, now: _FirstSeen) -> float:
        """Return the variance of a motionless track's apparent motion, m².

        The drift of a receiver's offset is Gauss-Markov: 2 (1 - exp(-t/tau)) of its variance. Where
        another drone has told of that offset, it has moved by what is not unknown any more.
        """
        keep = self._source.decay((now.stamp_ns - first.stamp_ns) * 1e-9)
        firsts = np.arange(0, len(keep), COUNT)
        lasting = float(keep[firsts].min())
        drift = (
            2.0
            * (1.0 - lasting)
            * max(float(self._source.stationary[k : k + 2, k : k + 2].max()) for k in firsts)
        )
        told = max(float((first.receivers - now.receivers).max()), 0.0)
        return drift + first.variance + told + float(one.spread.max()) + TUNING.apparent_m**2


def _compared(one: Candidate, law: PositionLaw, row: int, stamp_ns: int) -> _FirstSeen:
    """Return a track relative to a reference."""
    own, variances = law.places([row]), law.covariance.diagonal()
    receivers = variances[law.receivers]
    least = float(receivers.reshape(-1, 2).max(axis=1).min())
    variance = max(float(variances[own].max()) - least, 0.0)
    return _FirstSeen(one.position - law.mean[own], variance, receivers, stamp_ns)
