# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Posterior of which track is which reference, and whether references are right.

A hypothesis says of each reference which track it is, or that it is none of them: out of view, or
not where it is said to be. Under it the positions of those tracks have the normal law that filter
and references state together, with what they share through the platform: two references support
one another even where the receiver is poor. Any other track lies anywhere nearby, and may move; so
may a reference that has come loose (`stationarity`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.references.candidates import Candidate
from aerial_gnss_ros.core.references.position_law import PositionLaw, blocks_apart

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HypothesesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    nearby_m: float = 10.0
    """How far off a wrong reference, or another thing of its class, lies, one sigma, m. Judged."""
    wrong_share: float = 0.01
    """Share of references that are wrong: mistyped, moved, or another one of the kind. Judged."""
    other_share: float = 0.05
    """The same where more tracks of that class than references are in view. Judged."""
    adrift: float = 0.1
    """Share of references that are adrift, of those that are not where they are said to be: most of
    these are mistyped, or another track of their class. Judged."""
    largest_count: int = 256
    """At most so many hypotheses are weighed; the tracks farthest off are left out. Judged."""


TUNING = HypothesesTuning()


@dataclass(frozen=True)
class Hypothesis:
    """Which tracks references are.

    Attributes:
        rows: row of the track by reference; a reference that is none of them is absent.
        probability: of it.
    """

    rows: dict[str, int]
    probability: float


def hypotheses(law: PositionLaw, candidates: list[Candidate]) -> list[Hypothesis]:
    """Return all hypotheses with their probabilities, the likeliest first.

    Args:
        law: of the tracks, without references.
        candidates: references, each with the tracks that it may be and what speaks against these.
    """
    choices = _choices(candidates)
    alone = {
        (one.name, row): _log_normal(law, [(one, row)], TUNING.nearby_m**2)
        for one, rows in zip(candidates, choices, strict=True)
        for row in rows
        if row is not None
    }
    found: list[tuple[float, dict[str, int]]] = []
    for chosen in product(*choices):
        pairs = [(one, row) for one, row in zip(candidates, chosen, strict=True) if row is not None]
        if len({row for _, row in pairs}) < len(pairs):
            continue
        fits = _log_normal(law, pairs) if pairs else 0.0
        for one, row in zip(candidates, chosen, strict=True):
            share = TUNING.other_share if one.crowded else TUNING.wrong_share
            if row is None:
                free = (one.motion(other).adrift for other in one.rows if other not in chosen)
                fits += math.log(share) + _log_none(max(free, default=0.0))
            else:
                fits += math.log(1.0 - share) - alone[one.name, row]
                fits += one.motion(row).nats
        found.append((fits, {one.name: row for one, row in pairs}))
    best = max(fits for fits, _ in found)
    total = sum(math.exp(fits - best) for fits, _ in found)
    weighed = [Hypothesis(rows, math.exp(fits - best) / total) for fits, rows in found]
    return sorted(weighed, key=lambda one: -one.probability)


def _choices(candidates: list[Candidate]) -> list[list[int | None]]:
    """Return the tracks that each reference may be, None for none of them, of few hypotheses."""
    most = max((len(one.rows) for one in candidates), default=0)
    while most > 1 and math.prod(1 + min(len(one.rows), most) for one in candidates) > (
        TUNING.largest_count
    ):
        most -= 1
    choices: list[list[int | None]] = []
    for one in candidates:
        count = math.prod(len(chosen) for chosen in choices)
        kept = one.rows[:most] if 2 * count <= TUNING.largest_count else ()
        choices.append([None, *kept])
    return choices


def _log_none(adrift: float) -> float:
    """Return the log likelihood of motions if a reference is none of the tracks, or adrift.

    Args:
        adrift: log odds of the track whose motion speaks most for that it is adrift.
    """
    return float(np.logaddexp(math.log1p(-TUNING.adrift), math.log(TUNING.adrift) + adrift))


def _log_normal(law: PositionLaw, pairs: list[tuple[Candidate, int]], more: float = 0.0) -> float:
    """Return the log density of tracks at the positions of references.

    Args:
        law: of the tracks.
        pairs: of references and rows.
        more: variance that is added on each axis, m².
    """
    own = law.places([row for _, row in pairs])
    spread = law.covariance[np.ix_(own, own)] + more * np.eye(len(own))
    spread += blocks_apart(np.array([one.spread for one, _ in pairs]))
    apart = np.concatenate([one.position for one, _ in pairs]) - law.mean[own]
    _, log_determinant = np.linalg.slogdet(2.0 * math.pi * spread)
    return -0.5 * (float(log_determinant) + float(apart @ np.linalg.solve(spread, apart)))
