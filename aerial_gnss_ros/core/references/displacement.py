# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the places of tracks since a former image tell of whether one has moved.

Errors of the platform displace all tracks alike, so what the other tracks did in the same time
tells them from motion: displaced like the reference, they speak for an error; left where they were,
for motion. How large such errors are is known roughly only (a latency or a compass that is still to
be found out), so their law has long tails (Student).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import inverse_of_errors
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, NamedTrack
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.source import Source

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class DisplacementTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    apparent_m: float = 0.3
    """Apparent motion of what stays, by errors of its boxes, one sigma, m. Judged."""
    swim_mps: float = 0.3
    """Velocity of what has come loose, and of other robots, one sigma of each axis, m/s. Judged."""
    unlike: float = 0.3
    """Part of a common displacement by which tracks differ: a camera that turns displaces what is
    far off by more. Judged."""
    misfit: float = 0.15
    """Part of the reference's displacement by errors that are not stated, by which other tracks are
    off while it is used. Judged."""
    freedom: float = 4.0
    """Degrees of freedom of the platform's errors: how roughly their sizes are known. Judged."""


TUNING = DisplacementTuning()


@dataclass(frozen=True)
class Glimpse:
    """Where tracks and references were at one time.

    Attributes:
        stamp_ns: of the image, ns.
        places: (n, 2) of the tracks in view, m.
        variances: (n,) of these beyond a receiver's offset, m².
        rows: label of each, with its row in the two above.
        expected: where the box of each reference should be, m.
        receivers: (2 N,) variances of the receivers' offsets, m².
        by_errors: (n, 2, 9 N) derivatives of the places by the platforms' errors (regression).
        errors: (9 N, 9 N) covariance of these.
    """

    stamp_ns: int
    places: Array
    variances: Array
    rows: dict[str, int]
    expected: dict[str, Array]
    receivers: Array
    by_errors: Array
    errors: Array

    @classmethod
    def of(
        cls,
        candidates: Sequence[Candidate],
        tracks: Sequence[NamedTrack],
        law: PositionLaw,
        stamp_ns: int,
    ) -> Glimpse:
        """Return where a law's tracks in view, and references, are.

        Args:
            candidates: references.
            tracks: by row of the filter.
            law: of these tracks.
            stamp_ns: of the image, ns.
        """
        slots = [
            slot for slot, row in enumerate(law.rows.tolist())
            if tracks[row].robot_id and tracks[row].last_seen_ns == stamp_ns
        ]  # fmt: skip
        first, diagonal = law.errors, law.covariance.diagonal()
        receivers = diagonal[law.receivers]
        least = float(receivers.reshape(-1, 2).max(axis=1).min())
        variances = diagonal[first:].reshape(-1, 4)[slots, :2].max(axis=1, initial=0.0)
        return cls(
            stamp_ns,
            law.mean[first:].reshape(-1, 4)[slots, :2],
            np.maximum(variances - least, 0.0),
            {tracks[int(law.rows[slot])].robot_id: i for i, slot in enumerate(slots)},
            {one.name: one.position for one in candidates},
            receivers,
            _by_errors(law)[slots],
            law.covariance[:first, :first].copy(),
        )


@dataclass(frozen=True)
class Look:
    """What one look at a track tells.

    Attributes:
        nats: log odds that it stays to that it swims.
        tells: what these are of what does not move at all: how well the look tells one from the
            other.
        metres: by which it has moved.
        misfit: see `Motion`.
    """

    nats: float = 0.0
    tells: float = 0.0
    metres: float = 0.0
    misfit: float = 0.0

    @property
    def rests(self) -> float:
        """Log odds as evidence of rest: others displaced alike explain motion, but show no rest."""
        return min(self.nats, self.tells)


def looks_since(
    then: Glimpse, now: Glimpse, one: Candidate, tracks: Sequence[NamedTrack], source: Source
) -> dict[int, Look]:
    """Return what the places of a reference's tracks tell since a former image, by row.

    What was unknown of a track's place then, and is known now, has moved it by as much.

    Args:
        then: the former image.
        now: the last one.
        one: the reference, with the tracks that it may be.
        tracks: by row of the filter.
        source: what is estimated without references.
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
    own, platform = learnt + aside + TUNING.apparent_m**2, _receivers_drift(then, now, source)
    swum = (TUNING.swim_mps * (now.stamp_ns - then.stamp_ns) * 1e-9) ** 2
    slots = [of_label[tracks[row].robot_id] for row in rows]
    apart = shifts[slots] - (now.expected[one.name] - then.expected[one.name])
    squared: Array = (apart**2).sum(axis=1)
    total = platform + own[slots] + float(one.spread.max())
    stays = -(0.5 * TUNING.freedom + 1.0) * np.log1p(squared / (TUNING.freedom * total))
    swims = -np.log1p(swum / total) - 0.5 * squared / (total + swum)
    # If it stays, others are displaced as it is, but for what its own place explains.
    error = np.maximum(platform, 0.5 * squared - own[slots])
    part = error / (error + own[slots])
    alike = part * (own[slots] + TUNING.unlike**2 * squared)
    rest = shifts - part[:, None, None] * apart[:, None]
    others = np.arange(len(common)) != np.array(slots)[:, None]
    nats = stays - swims + _log_others(rest, own, alike, swum, others)
    nats = nats - _log_others(shifts[None], own, np.array([platform]), swum, others)
    misfit = TUNING.misfit**2 * np.maximum(0.5 * squared - total, 0.0)
    each = (nats, np.log1p(swum / total), np.sqrt(squared), misfit)
    return dict(zip(rows, map(Look, *(one.tolist() for one in each)), strict=True))


def _receivers_drift(then: Glimpse, now: Glimpse, source: Source) -> float:
    """Return the variance of a displacement by the receivers' offsets on each axis, m².

    The drift of a receiver's offset is Gauss-Markov: 2 (1 - exp(-t/tau)) of its variance. Where
    another drone has told of that offset, it has moved by what is not unknown any more.
    """
    keep = source.decay((now.stamp_ns - then.stamp_ns) * 1e-9)
    firsts = np.arange(0, len(keep), COUNT)
    variance = max(float(source.stationary[k : k + 2, k : k + 2].max()) for k in firsts)
    told = max(float((then.receivers - now.receivers).max()), 0.0)
    return 2.0 * (1.0 - float(keep[firsts].min())) * variance + told


def _by_errors(law: PositionLaw) -> Array:
    """Return derivatives (n, 2, 9 N) of a law's robots by the platforms' errors (regression)."""
    first = law.errors
    cross = law.covariance[first:, :first].reshape(-1, 4, first)[:, :2]
    found: Array = cross @ inverse_of_errors(law.covariance[:first, :first])
    return found


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
