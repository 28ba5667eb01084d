# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transient clutter: foam and glint that images show several times in one place, but not for long.

Boxes of such a thing are not independent, so a count of boxes is no evidence against it. What is:
how long it has been seen, as foam dissolves, and its scores, as a detector is seldom sure of foam.
How much of it there is, tracks tell that ended soon without having been robots.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class TransientsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    memory_s: float = 20.0
    """Time for which a track that ended counts, s. Judged."""
    lifetime_s: float = 1.0
    """Mean time for which foam stays in one place, s. Judged: hardly any lasts three seconds."""
    vanished_s: float = 0.5
    """Time after which a track that is not seen has ended, s. Judged."""
    missed_s: float = 10.0
    """Time for which a robot that vanished may only be missed, s. Judged."""
    unseen: float = 2.0
    """Expected number of transients in view that have not been seen to end. Judged: with fewer,
    foam is taken for robots before any has ended; with more, robots of low scores wait longer."""
    score_scale: float = 0.11
    """Mean excess of clutter's scores over the least score that is used: over 0.3, the median of 55
    boxes on foam, glint and stones in photographs that training had not seen lies 0.1 higher."""


TUNING = TransientsTuning()


def outlasted(lasted_s: float) -> float:
    """Return the share of transients that last longer than a time, s."""
    return math.exp(-lasted_s / TUNING.lifetime_s)


class Transients:
    """Counts tracks that ended soon.

    Args:
        min_score: least score of a box that is used.
    """

    def __init__(self, min_score: float) -> None:
        self.min_score = min_score
        self.reset()

    def reset(self) -> None:
        """Forget all of them."""
        self._ended: tuple[tuple[int, float], ...] = ()

    def note(self, stamp_ns: int, probability: float) -> None:
        """Note a track that ended without being a robot.

        Args:
            stamp_ns: of the image, ns.
            probability: that it was a transient.
        """
        if not probability:
            return
        oldest_ns = stamp_ns - TUNING.memory_s * 1e9
        self._ended = (*(one for one in self._ended if one[0] > oldest_ns), (stamp_ns, probability))

    def expected(self, stamp_ns: int, vanishing: float, seen_s: float, score: float) -> float:
        """Return the expected number of transients that last as long and score as high as a track.

        Args:
            stamp_ns: of the image, ns.
            vanishing: expected number of those that have ended, but are not noted yet.
            seen_s: time for which images have shown the track, s.
            score: mean of its boxes' scores.
        """
        oldest_ns = stamp_ns - TUNING.memory_s * 1e9
        ended = sum(share for ended_ns, share in self._ended if ended_ns > oldest_ns)
        count = TUNING.unseen + vanishing + ended
        excess = max(0.0, score - self.min_score) / TUNING.score_scale
        return count * outlasted(seen_s) * math.exp(-excess)
