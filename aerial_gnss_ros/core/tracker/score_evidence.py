# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a track scores as robots do.

Swimmers, boats and docks last as robots do. Single boxes of them score as high now and then; in the
mean they score lower, and a detector's errors differ from one image to the next. On 13 swimmers in
62 images 0.5 s apart, of which training had seen none, the log odds of two networks' scores vary by
0.5 and 0.8 within a swimmer, and by 0.3 and 0.5 between swimmers (`benchmarks/lasting_scores.py`).
So the mean over a track tells more than any of its boxes.

How robots score depends on the detector. The robots of a flight tell: what scores lower than they
do is the less likely to be one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.models.evidence import UNCLEAR


@dataclass(frozen=True)
class ScoreEvidenceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    spread: float = 0.8
    """Log odds of the scores of one thing's boxes, one sigma: of swimmers, by the less even of two
    networks. Measured; on rendered robots less than half of it."""
    between: float = 0.5
    """Log odds between robots, one sigma. Measured: 0.48 on rendered flights."""
    correlation_s: float = 0.3
    """Correlation time of its deviations, s. Measured: 0.16 is left after 0.5 s."""
    sigmas: float = 1.0
    """Margin by which the mean must exceed the least score, its own standard deviations. Judged:
    tested with every image, it would be exceeded by chance without one."""
    clip: float = 0.001
    """Scores are taken as at least this, and as at most 1 less this."""


TUNING = ScoreEvidenceTuning()


def log_odds(score: float) -> float:
    """Return log(p / (1 - p)) of a score, which is clipped."""
    within = min(max(score, TUNING.clip), 1.0 - TUNING.clip)
    return math.log(within / (1.0 - within))


def scores_as_robots(odds_sum: float, count: int, lasted_s: float, least: float) -> bool:
    """Return whether a track's mean score exceeds the least one of robots by its uncertainty.

    Args:
        odds_sum: sum of its boxes' log odds.
        count: number of these boxes; 0: nothing is known against it.
        lasted_s: time from the first of them to the last one, s.
        least: score of robots in the mean; 0: any.
    """
    if not count or not least:
        return True
    looks = independent_looks(count, lasted_s)
    margin = TUNING.sigmas * TUNING.spread / math.sqrt(looks)
    return odds_sum / count - margin >= log_odds(least)


def independent_looks(count: int, lasted_s: float) -> float:
    """Return how many independent boxes tell as much in the mean as a track's do.

    Args:
        count: number of its boxes.
        lasted_s: time from the first of them to the last one, s.
    """
    return min(count, 1.0 + 0.5 * lasted_s / TUNING.correlation_s)


def chance_of_score(track: Track, robots: Sequence[Track]) -> float:
    """Return the chance of a robot whose boxes score as low in the mean; 1: as others do.

    It is not below `UNCLEAR`: what robots score may differ by more than was measured.

    Args:
        track: that may be a robot.
        robots: that are known; none: nothing is known against it.
    """
    known = [one for one in robots if one.score_count and one.class_id == track.class_id]
    if not known or not track.score_count:
        return 1.0
    usual = sum(one.odds_sum / one.score_count for one in known) / len(known)
    lower = usual - track.odds_sum / track.score_count
    if lower <= 0.0:
        return 1.0
    own = TUNING.spread**2 / independent_looks(track.score_count, track.lasted_s)
    variance = own + TUNING.between**2 + (TUNING.spread**2 + TUNING.between**2) / len(known)
    return max(UNCLEAR, math.erfc(lower / math.sqrt(2.0 * variance)))
