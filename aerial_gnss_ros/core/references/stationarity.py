# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence that a track has moved and so is no reference that stays.

Errors of the platform displace all tracks alike, so what the other tracks did in the same time
tells them from motion: displaced like the reference, they speak for an error; left where they were,
for a thing adrift. How large such errors are is known roughly only (a latency or a compass that is
still to be found out), so their law has long tails (Student). Errors pass: only the last
`TUNING.window_s` count, and a track that stays from then on may be the reference again.

Where others are of the reference's class, what is not the reference swims. The track's velocity
tells it first, later how far it has come: all of that shows one motion and counts once, so that one
image that puts a velocity off does not outweigh that the track has stayed until then.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import inverse_of_errors
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, Motion, NamedTrack
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.source import Source

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class StationarityTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    apparent_m: float = 0.3
    """Apparent motion of what stays, by errors of its boxes, one sigma, m. Judged."""
    window_s: float = 20.0
    """Time within which motion is looked for, s. Judged."""
    every_s: float = 1.0
    """How often places are kept, s. Judged."""
    swim_mps: float = 0.3
    """Velocity of what has come loose, and of other robots, one sigma of each axis, m/s. Judged."""
    unlike: float = 0.3
    """Part of a common displacement by which tracks differ: a camera that turns displaces what is
    far off by more. Judged."""
    misfit: float = 0.15
    """Part of the reference's displacement by errors that are not stated, by which other tracks are
    off while it is used. Judged."""
    rest_mps: float = 0.03
    """Velocity that something which stays seems to have all the same, one sigma, m/s. Judged."""
    adrift: float = 0.1
    """Share of references that are adrift, of those that are not where they are said to be: most of
    these are mistyped, or another track of their class. Judged."""
    freedom: float = 4.0
    """Degrees of freedom of the platform's errors: how roughly their sizes are known. Judged."""


TUNING = StationarityTuning()


@dataclass(frozen=True)
class _Glimpse:
    """Where tracks and references were at one time.

    Attributes:
        stamp_ns: of the image, ns.
        places: (n, 2) of the tracks in view, m.
        variances: (n,) of these beyond a receiver's offset, m².
        rows: label of each, with its row in the two above.
        expected: where the box of each reference should be, m.
        receivers: (2 N,) variances of the receivers' offsets, m².
        by_errors: (n, 2, 7 N) derivatives of the places by the platforms' errors (regression).
        errors: (7 N, 7 N) covariance of these.
    """

    stamp_ns: int
    places: Array
    variances: Array
    rows: dict[str, int]
    expected: dict[str, Array]
    receivers: Array
    by_errors: Array
    errors: Array


@dataclass(frozen=True)
class _Look:
    """What one look at a track tells.

    Attributes:
        rests: log odds that it stays to that it swims.
        tells: what these are of what does not move at all: how well the look tells one from the
            other.
        nats: log odds that it stays to that it is adrift.
        metres: by which it has moved.
        misfit: see `Motion`.
    """

    rests: float = 0.0
    tells: float = 0.0
    nats: float = 0.0
    metres: float = 0.0
    misfit: float = 0.0


class StationarityTest:
    """Weighs whether tracks that may be references have moved lately.

    Args:
        source: what is estimated without references.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._kept: deque[_Glimpse] = deque()
        self._accepted_jumps = np.zeros(2)

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        self._kept = deque(
            replace(one, rows={names.get(name, name): row for name, row in one.rows.items()})
            for one in self._kept
        )

    def forget(self, name: str) -> None:
        """Restart the test of a reference whose position has changed."""
        for glimpse in self._kept:
            glimpse.expected.pop(name, None)

    def restart(self) -> None:
        """Compare from now on: another calibration has moved the tracks."""
        self._kept.clear()

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
            self._kept.clear()
        now = _glimpse(candidates, tracks, law, stamp_ns)
        while self._kept and stamp_ns - self._kept[0].stamp_ns > TUNING.window_s * 1e9:
            self._kept.popleft()
        count = len(self._kept)
        # A long time shows slow motion, a shorter one that of what has turned back.
        lags = {count * share // 4 for share in range(4)} if count else set()
        found: list[dict[int, Motion]] = []
        for one in candidates:
            looks: dict[int, list[_Look]] = {}
            if one.stays:
                looks = {row: [_by_velocity(law, row)] for row in one.rows}
                for lag in lags:
                    for row, look in self._since(one, tracks, self._kept[lag], now).items():
                        looks[row].append(look)
            found.append({row: _judged(some, one.crowded) for row, some in looks.items()})
        if not self._kept or stamp_ns - self._kept[-1].stamp_ns >= TUNING.every_s * 1e9:
            self._kept.append(now)
        return found

    def _since(
        self, one: Candidate, tracks: Sequence[NamedTrack], then: _Glimpse, now: _Glimpse
    ) -> dict[int, _Look]:
        """Return what the places of a reference's tracks tell since a former image.

        What was unknown of a track's place then, and is known now, has moved it by as much.
        """
        common = [label for label in now.rows if label in then.rows]
        of_label = {label: i for i, label in enumerate(common)}
        rows = [row for row in one.rows if tracks[row].robot_id in of_label]
        if not rows or one.name not in then.expected:
            return {}
        mine, theirs = [now.rows[label] for label in common], [then.rows[label] for label in common]
        shifts = now.places[mine] - then.places[theirs]
        learnt = np.maximum(then.variances[theirs] - now.variances[mine], 0.0)
        # Errors that last displace otherwise what is seen from another side.
        otherwise = now.by_errors[mine] - then.by_errors[theirs]
        aside = 0.5 * np.einsum("nij,jk,nik->n", otherwise, now.errors, otherwise)
        own, platform = learnt + aside + TUNING.apparent_m**2, self._platform(then, now)
        swum = (TUNING.swim_mps * (now.stamp_ns - then.stamp_ns) * 1e-9) ** 2
        slots = [of_label[tracks[row].robot_id] for row in rows]
        apart = shifts[slots] - (now.expected[one.name] - then.expected[one.name])
        squared: Array = (apart**2).sum(axis=1)
        total = platform + own[slots] + float(one.spread.max())
        stays = -(0.5 * TUNING.freedom + 1.0) * np.log1p(squared / (TUNING.freedom * total))
        adrift = -np.log1p(swum / total) - 0.5 * squared / (total + swum)
        # If it stays, others are displaced as it is, but for what its own place explains.
        error = np.maximum(platform, 0.5 * squared - own[slots])
        part = error / (error + own[slots])
        alike = part * (own[slots] + TUNING.unlike**2 * squared)
        rest = shifts - part[:, None, None] * apart[:, None]
        others = np.arange(len(common)) != np.array(slots)[:, None]
        nats = stays - adrift + _log_others(rest, own, alike, swum, others)
        nats = nats - _log_others(shifts[None], own, np.array([platform]), swum, others)
        misfit = TUNING.misfit**2 * np.maximum(0.5 * squared - total, 0.0)
        # Others that are displaced alike explain motion; they are no evidence of rest.
        tells = np.log1p(swum / total)
        each = (np.minimum(nats, tells), tells, nats, np.sqrt(squared), misfit)
        return dict(zip(rows, map(_Look, *(one.tolist() for one in each)), strict=True))

    def _platform(self, then: _Glimpse, now: _Glimpse) -> float:
        """Return the variance of a displacement by the receivers' offsets on each axis, m².

        The drift of a receiver's offset is Gauss-Markov: 2 (1 - exp(-t/tau)) of its variance. Where
        another drone has told of that offset, it has moved by what is not unknown any more.
        """
        keep = self._source.decay((now.stamp_ns - then.stamp_ns) * 1e-9)
        firsts = np.arange(0, len(keep), COUNT)
        variance = max(float(self._source.stationary[k : k + 2, k : k + 2].max()) for k in firsts)
        told = max(float((then.receivers - now.receivers).max()), 0.0)
        return 2.0 * (1.0 - float(keep[firsts].min())) * variance + told


def _glimpse(
    candidates: Sequence[Candidate], tracks: Sequence[NamedTrack], law: PositionLaw, stamp_ns: int
) -> _Glimpse:
    """Return where a law's tracks in view, and references, are."""
    slots = [
        slot for slot, row in enumerate(law.rows.tolist())
        if tracks[row].robot_id and tracks[row].last_seen_ns == stamp_ns
    ]  # fmt: skip
    first, diagonal = law.errors, law.covariance.diagonal()
    receivers = diagonal[law.receivers]
    least = float(receivers.reshape(-1, 2).max(axis=1).min())
    variances = diagonal[first:].reshape(-1, 4)[slots, :2].max(axis=1, initial=0.0)
    return _Glimpse(
        stamp_ns,
        law.mean[first:].reshape(-1, 4)[slots, :2],
        np.maximum(variances - least, 0.0),
        {tracks[int(law.rows[slot])].robot_id: i for i, slot in enumerate(slots)},
        {one.name: one.position for one in candidates},
        receivers,
        _by_errors(law)[slots],
        law.covariance[:first, :first].copy(),
    )


def _by_errors(law: PositionLaw) -> Array:
    """Return derivatives (n, 2, 7 N) of a law's robots by the platforms' errors (regression)."""
    first = law.errors
    cross = law.covariance[first:, :first].reshape(-1, 4, first)[:, :2]
    found: Array = cross @ inverse_of_errors(law.covariance[:first, :first])
    return found


def _by_velocity(law: PositionLaw, row: int) -> _Look:
    """Return what a track's velocity tells: of whether it has come adrift, nothing."""
    own = law.places([row]) + 2
    velocity, spread = law.mean[own], law.covariance[np.ix_(own, own)]
    rests, swims = (spread + v**2 * np.eye(2) for v in (TUNING.rest_mps, TUNING.swim_mps))
    tells = 0.5 * math.log(np.linalg.det(swims) / np.linalg.det(rests))
    squares = [float(velocity @ np.linalg.solve(one, velocity)) for one in (rests, swims)]
    return _Look(tells - 0.5 * (squares[0] - squares[1]), tells)


def _judged(looks: Sequence[_Look], crowded: bool) -> Motion:
    """Return the motion of a track by all looks at it.

    What is not the reference most often stays, too. Where others are of its class it swims, and
    only the look that tells this best counts, since all of them show one motion. Else it is adrift,
    for as long as speaks most for that.

    Args:
        looks: by its velocity, then since former images.
        crowded: whether others are of its class.
    """
    best, worst = max(looks, key=lambda one: one.tells), min(looks, key=lambda one: one.nats)
    usual, adrift, share = -best.rests if crowded else 0.0, -worst.nats, TUNING.adrift
    most = max(usual, adrift)
    other = (1.0 - share) * math.exp(usual - most) + share * math.exp(adrift - most)
    return Motion(-most - math.log(other), worst.metres, max(one.misfit for one in looks))


def _log_others(apart: Array, own: Array, alike: Array, swum: float, others: Flags) -> Array:
    """Return the log density (m,) of what n tracks did, given the displacement of all of them.

    Either each stays or swims by itself, or all drift with one current.

    Args:
        apart: (m, n, 2) or (1, n, 2) by which they were displaced otherwise, m.
        own: (n,) variances of that, each for itself, m².
        alike: (m,) or (1,) variance in common, m².
        swum: variance of how far what swims or drifts has come, m².
        others: (m, n) which of them count.
    """
    squared, each = (apart**2).sum(axis=-1), own + alike[:, None]
    both = [-np.log(total) - 0.5 * squared / total for total in (each, each + swum)]
    alone = np.where(others, np.logaddexp(*both) - math.log(2.0), 0.0).sum(axis=1)
    count = np.maximum(others.sum(axis=1), 1)
    mean = np.where(others[:, :, None], apart, 0.0).sum(axis=1) / count[:, None]
    spread = np.where(others, own, 0.0).sum(axis=1) / count
    spread = np.where(spread > 0.0, spread, 1.0)
    scatter = np.where(others, ((apart - mean[:, None]) ** 2).sum(axis=-1), 0.0).sum(axis=1)
    total = spread / count + alike + swum
    drift = -np.log(total) - 0.5 * (mean**2).sum(axis=-1) / total
    drift = drift - (count - 1) * np.log(spread) - np.log(count) - 0.5 * scatter / spread
    together: Array = np.logaddexp(alone, drift)
    return np.where(others.any(axis=1), together, 0.0)
