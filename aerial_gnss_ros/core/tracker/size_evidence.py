# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a track is as long as robots are, and how many specks like it are expected to last.

The edges of a box of few pixels are uncertain, so that a single one is judged tolerantly
(`wrong_size`). Their errors differ from one image to the next, and the mean over a track tells how
long it is, but for what all its boxes have in common: foam around a robot, or a part of it that
does not stand out.

Glint and foam have no length of their own: the smaller, the more of them, down to what an image
resolves. Tracks that are too short to be robots tell how many specks there are, how long they
last, how they score and how they move; so many longer ones are expected as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.georeferencing.size_fit import SizeSums
from aerial_gnss_ros.core.tracker.score_evidence import independent_looks

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SizeEvidenceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    least_chance: float = 0.05
    """Chance of a robot with a mean size as wrong as a track's, below which it is none. Judged."""
    speck_scale: float = 0.3
    """Mean of the logarithm of length by which specks are longer than any given length. Measured
    over that of a robot of 0.4 m: 0.20, 0.26 and 0.38 on three photographs of a lake."""
    speck_speed: float = 0.15
    """Speed of specks relative to one another, each axis, where few are seen, m/s. Judged."""
    mistaken_share: float = 0.1
    """Share of the specks that seem to move anyhow, as their tracks take one for another.
    Judged."""


TUNING = SizeEvidenceTuning()


def chance_of_size(sums: SizeSums, lasted_s: float) -> float:
    """Return the chance of a robot whose boxes are as wrong in the mean; 1: they are not wrong.

    Args:
        sums: of a track's boxes; none: nothing is known against it.
        lasted_s: time from the first of them to the last one, s.
    """
    return _chance(max(sums.shortfall, sums.excess), sums, lasted_s)


def expected_specks(
    track: Track, tracks: Iterable[Track], seen_s: float, min_score: float, score_scale: float
) -> float:
    """Return the expected number of specks that last, score, move and are as long as a track.

    Args:
        track: that may be a robot.
        tracks: all of them; those too short to be robots are specks.
        seen_s: time for which images have shown the track, s.
        min_score: least score of a box that is used.
        score_scale: mean excess of clutter's scores over it, unless specks score higher.
    """
    specks, likely = list[Track](), list[float]()
    for one in tracks:
        if one is track or one.robot_id or one.lasted_s < seen_s:
            continue
        share = 1.0 - _chance(one.sizes.shortfall, one.sizes, one.lasted_s)
        if share:
            specks.append(one)
            likely.append(share)
    if not specks:
        return 0.0
    shares = np.array(likely)
    longer_by = np.array([_mean_shortfall(one) for one in specks]) - _mean_shortfall(track)
    excess = np.array([max(0.0, one.mean_score - min_score) for one in specks])
    scale = max(score_scale, float(shares @ excess / shares.sum()))
    as_long = float(shares @ np.exp(-np.maximum(longer_by, 0.0) / TUNING.speck_scale))
    as_sure = math.exp(-max(0.0, track.mean_score - min_score) / scale)
    return as_long * as_sure * _share_moving(track, np.stack([s.velocity for s in specks]), shares)


def _share_moving(track: Track, velocities: Array, shares: Array) -> float:
    """Return the share of specks that move as differently from the others as a track does.

    What is wrong with the pose moves all of them alike, and counts for nothing.

    Args:
        track: that may be a robot.
        velocities: (n, 2) of the specks, East, North, m/s.
        shares: (n,) probabilities that they are specks.
    """
    mean = shares @ velocities / shares.sum()
    off = velocities - mean
    among = (shares[:, None] * off).T @ off + TUNING.speck_speed**2 * np.eye(2)
    spread = among / (shares.sum() + 1.0) + track.velocity_spread
    away = track.velocity - mean
    share = math.exp(-0.5 * float(away @ np.linalg.solve(spread, away)))
    return TUNING.mistaken_share + (1.0 - TUNING.mistaken_share) * share


def _mean_shortfall(track: Track) -> float:
    return track.sizes.shortfall / track.sizes.count if track.sizes.count else 0.0


def _chance(misfit: float, sums: SizeSums, passed_s: float) -> float:
    """Return the chance of a sum of misfits that is as large, of a robot of the wrongest size."""
    if not sums.count or misfit <= 0.0:
        return 1.0
    looks = independent_looks(sums.count, passed_s)
    variance = (sums.shared_variance + sums.white_variance / looks) / sums.count
    return math.erfc(misfit / sums.count / math.sqrt(2.0 * variance))
