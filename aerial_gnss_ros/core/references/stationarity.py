# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence that a track has moved and so is no reference that stays.

Errors of the platform pass: only displacements within the last `TUNING.window_s` count, and a track
that stays from then on may be the reference again.

Where others are of the reference's class, what is not the reference swims. Which track stays does
not change, so what each span of `TUNING.span_s` tells of it adds up: errors that displace all for
some seconds do not outweigh that a track has stayed for a minute. The velocity and the displacement
since the last span's end show one motion, of which only the one that tells more counts.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aerial_gnss_ros.core.references.candidates import Candidate, Motion, NamedTrack
from aerial_gnss_ros.core.references.displacement import TUNING as DISPLACEMENT
from aerial_gnss_ros.core.references.displacement import Glimpse, Look, looks_since
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.source import Source


@dataclass(frozen=True)
class StationarityTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    span_s: float = 5.0
    """Time of which a displacement counts as evidence of its own that a track stays or swims, s.
    Judged."""
    most_nats: float = 8.0
    """Largest log odds of former spans: what has stayed may swim from now on. Judged."""
    window_s: float = 20.0
    """Time within which motion is looked for, s. Judged."""
    every_s: float = 1.0
    """How often places are kept, s. Judged."""
    rest_mps: float = 0.03
    """Velocity that something which stays seems to have all the same, one sigma, m/s. Judged."""


TUNING = StationarityTuning()


@dataclass(frozen=True)
class _Rested:
    """What former spans tell of a track.

    Attributes:
        nats: log odds that it stays to that it swims.
        loose: log odds that it stayed at first and has come loose since, to the same.
    """

    nats: float = 0.0
    loose: float = 0.0

    def then(self, rests: float) -> _Rested:
        """Return what is told after another span, by the log odds of that one."""
        nats = min(max(self.nats + rests, -TUNING.most_nats), TUNING.most_nats)
        return _Rested(nats, max(self.loose, nats))


class StationarityTest:
    """Weighs whether tracks that may be references have moved lately.

    Args:
        source: what is estimated without references.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._kept: deque[Glimpse] = deque()
        self._begun: Glimpse | None = None
        # By reference and label.
        self._rested: dict[tuple[str, str], _Rested] = {}
        self._accepted_jumps = np.zeros(2)

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        self._kept = deque(
            replace(one, rows={names.get(name, name): row for name, row in one.rows.items()})
            for one in self._kept
        )
        self._begun = None
        self._rested = {
            (one, names.get(label, label)): told for (one, label), told in self._rested.items()
        }

    def forget(self, name: str) -> None:
        """Restart the test of a reference whose position has changed."""
        for glimpse in self._kept:
            glimpse.expected.pop(name, None)
        self._begun = None
        self._rested = {key: told for key, told in self._rested.items() if key[0] != name}

    def restart(self) -> None:
        """Compare from now on: another calibration has moved the tracks."""
        self._kept.clear()
        self._begun = None

    def update(
        self,
        candidates: Sequence[Candidate],
        tracks: Sequence[NamedTrack],
        law: PositionLaw,
        stamp_ns: int,
    ) -> list[dict[int, Motion]]:
        """Return the apparent motions of each reference's tracks, by row.

        Args:
            candidates: references, with the tracks that each may be.
            tracks: by row of the filter.
            law: of these tracks.
            stamp_ns: of the image, ns.
        """
        believed = self._source.believed
        if not np.array_equal(self._accepted_jumps, believed):
            self._accepted_jumps = believed.copy()
            self.restart()
        while self._kept and stamp_ns - self._kept[0].stamp_ns > TUNING.window_s * 1e9:
            self._kept.popleft()
        now = Glimpse.of(candidates, tracks, law, stamp_ns)
        begun = self._begun or now
        found = [
            self._motions(one, tracks, law, begun, now) if one.stays else {} for one in candidates
        ]
        if stamp_ns - begun.stamp_ns >= TUNING.span_s * 1e9:
            self._add_up(candidates, tracks, begun, now)
            begun = now
        self._begun = begun
        if not self._kept or stamp_ns - self._kept[-1].stamp_ns >= TUNING.every_s * 1e9:
            self._kept.append(now)
        return found

    def _motions(
        self,
        one: Candidate,
        tracks: Sequence[NamedTrack],
        law: PositionLaw,
        begun: Glimpse,
        now: Glimpse,
    ) -> dict[int, Motion]:
        """Return the motions of a reference's tracks, by row.

        Args:
            one: the reference.
            tracks: by row of the filter.
            law: of these tracks.
            begun: the image at which the present span began.
            now: the last image.
        """
        # What comes loose now has not moved yet.
        looks = {row: [Look()] for row in one.rows}
        # A long time shows slow motion, a shorter one that of what has turned back.
        for lag in {len(self._kept) * share // 4 for share in range(4)} if self._kept else ():
            for row, look in looks_since(self._kept[lag], now, one, tracks, self._source).items():
                looks[row].append(look)
        if not one.crowded:
            return {row: _alone(some) for row, some in looks.items()}
        lately = looks_since(begun, now, one, tracks, self._source)
        return {
            row: _in_a_crowd(
                some,
                self._rested.get((one.name, tracks[row].robot_id), _Rested()),
                [_by_velocity(law, row), lately.get(row, Look())],
            )
            for row, some in looks.items()
        }

    def _add_up(
        self,
        candidates: Sequence[Candidate],
        tracks: Sequence[NamedTrack],
        begun: Glimpse,
        now: Glimpse,
    ) -> None:
        """Add what a span of time has told of each track to what former ones have."""
        for one in candidates:
            looks = looks_since(begun, now, one, tracks, self._source) if one.stays else {}
            for row, look in looks.items():
                key = one.name, tracks[row].robot_id
                self._rested[key] = self._rested.get(key, _Rested()).then(look.rests)


def _by_velocity(law: PositionLaw, row: int) -> Look:
    """Return what a track's velocity tells."""
    own = law.places([row]) + 2
    velocity, spread = law.mean[own], law.covariance[np.ix_(own, own)]
    rests, swims = (spread + v**2 * np.eye(2) for v in (TUNING.rest_mps, DISPLACEMENT.swim_mps))
    tells = 0.5 * math.log(np.linalg.det(swims) / np.linalg.det(rests))
    squares = [float(velocity @ np.linalg.solve(one, velocity)) for one in (rests, swims)]
    return Look(tells - 0.5 * (squares[0] - squares[1]), tells)


def _alone(looks: Sequence[Look]) -> Motion:
    """Return the motion of a track where none but the reference is of its class.

    What is not the reference most often stays, too, so that rest tells nothing. What is adrift has
    been so for as long as speaks most for that.

    Args:
        looks: since former images.
    """
    worst = min(looks, key=lambda one: one.nats)
    return Motion(0.0, -worst.nats, worst.metres, max(one.misfit for one in looks))


def _in_a_crowd(looks: Sequence[Look], former: _Rested, lately: Sequence[Look]) -> Motion:
    """Return the motion of a track where others are of its class, which swim.

    What has come loose swims as they do.

    Args:
        looks: since former images.
        former: what former spans tell.
        lately: by its velocity, and since the end of the last of these spans.
    """
    rests = former.nats + max(lately, key=lambda one: one.tells).rests
    return replace(_alone(looks), nats=rests, adrift=former.loose)
