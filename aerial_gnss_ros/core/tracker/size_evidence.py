# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a track is as long as robots are, and how many specks like it are expected to last.

The edges of a box of few pixels are uncertain, so that a single one is judged tolerantly
(`wrong_size`). Their errors differ from one image to the next, and the mean over a track tells how
long it is, but for what all its boxes have in common: foam around a robot, or a part of it that
does not stand out.

Glint and foam have no length of their own: the smaller, the more of them, down to what an image
resolves. Tracks that are too short to be robots tell how many specks there are, how long they
last, and how they score; so many longer ones are expected as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.georeferencing.size_fit import SizeSums
from aerial_gnss_ros.core.tracker.score_evidence import independent_looks


@dataclass(frozen=True)
class SizeEvidenceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    least_chance: float = 0.05
    """Chance of a robot with a mean size as wrong as a track's, below which it is none. Judged."""
    speck_scale: float = 0.25
    """Mean of the logarithm of length by which specks are longer than any given length. Measured
    over that of a robot of 0.4 m: 0.20, 0.26 and 0.38 on three photographs of a lake."""


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
    """Return the expected number of specks that last, score and are as long as a track.

    Args:
        track: that may be a robot.
        tracks: all of them; those too short to be robots are specks.
        seen_s: time for which images have shown the track, s.
        min_score: least score of a box that is used.
        score_scale: mean excess of clutter's scores over it, unless specks score higher.
    """
    expected = excess = count = 0.0
    for one in tracks:
        if one is track or one.robot_id or one.lasted_s < seen_s:
            continue
        share = 1.0 - _chance(one.sizes.shortfall, one.sizes, one.lasted_s)
        if share:
            longer_by = max(0.0, _mean_shortfall(one) - _mean_shortfall(track))
            expected += share * math.exp(-longer_by / TUNING.speck_scale)
            excess += share * max(0.0, one.mean_score - min_score)
            count += share
    if not count:
        return 0.0
    scale = max(score_scale, excess / count)
    return expected * math.exp(-max(0.0, track.mean_score - min_score) / scale)


def _mean_shortfall(track: Track) -> float:
    return track.sizes.shortfall / track.sizes.count if track.sizes.count else 0.0


def _chance(misfit: float, sums: SizeSums, passed_s: float) -> float:
    """Return the chance of a sum of misfits that is as large, of a robot of the wrongest size."""
    if not sums.count or misfit <= 0.0:
        return 1.0
    looks = independent_looks(sums.count, passed_s)
    variance = (sums.shared_variance + sums.white_variance / looks) / sums.count
    return math.erfc(misfit / sums.count / math.sqrt(2.0 * variance))
