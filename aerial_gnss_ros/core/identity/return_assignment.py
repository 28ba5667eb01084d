# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which new track is which robot out of view, jointly: no robot is on two tracks."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import EarlierLabel
from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReturnAssignmentTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_hypotheses: int = 300
    """Greatest number of joint assignments that are followed, the likeliest ones. Judged."""


TUNING = ReturnAssignmentTuning()


@dataclass(frozen=True)
class Pairs:
    """Pairs of n robots out of view and m new tracks.

    Attributes:
        possible: (n, m) whether the track can be the robot.
        place: (n, m) minus twice the log likelihood ratio of position and velocity.
        odds: (n, m) likelihood ratio of the absence.
        ratio: (n, m) likelihood ratio of both to a new robot, with doubt; 0: impossible.
        absence_s: (n, m) how long the robot was submerged, s; NaN: it was not.
    """

    possible: NDArray[np.bool_]
    place: Array
    odds: Array
    ratio: Array
    absence_s: Array

    def beside(self, other: Pairs) -> Pairs:
        """Return these tracks and then others, of the same robots."""
        names = [one.name for one in fields(self)]
        return Pairs(*(np.hstack([getattr(self, k), getattr(other, k)]) for k in names))

    def of(self, column: int, labels: list[str]) -> dict[str, EarlierLabel]:
        """Return the robots that one track may be, by label; negligible ones are left out.

        Args:
            column: of the track.
            labels: (n,) of the robots.
        """
        rows = [self.place, self.odds, self.ratio, self.absence_s]
        return {
            label: EarlierLabel(*(float(one[i, column]) for one in rows))
            for i, label in enumerate(labels)
            if self.ratio[i, column] > EVIDENCE.forgotten
        }


def exclusive_probabilities(odds: Array) -> Array:
    """Return the probabilities (n, m) that a new track is a robot, if each robot is on one track.

    Args:
        odds: (n, m) likelihood ratios of each robot to a new one, by track; 0: impossible.
    """
    hypotheses: list[tuple[float, tuple[int, ...]]] = [(1.0, ())]
    for column in odds.T.tolist():
        longer = [(weight, (*taken, -1)) for weight, taken in hypotheses]
        for row, ratio in enumerate(column):
            if ratio > 0.0:
                longer += [
                    (weight * ratio, (*taken, row))
                    for weight, taken in hypotheses
                    if row not in taken
                ]
        longer.sort(key=lambda one: -one[0])
        best = longer[0][0]
        hypotheses = [(weight / best, taken) for weight, taken in longer[: TUNING.most_hypotheses]]
    probabilities = np.zeros(odds.shape)
    for weight, taken in hypotheses:
        for column_, row in enumerate(taken):
            if row >= 0:
                probabilities[row, column_] += weight
    return probabilities / sum(weight for weight, _ in hypotheses)
