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

    most_hypotheses: int = 100
    """Greatest number of sets of robots taken that are followed, the likeliest ones. Judged."""


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

    Tracks are taken one after the other. What follows depends on which robots are taken, as far as
    later tracks may be them: so assignments that take the same ones are added up (forward and
    backward recursion).

    Args:
        odds: (n, m) likelihood ratios of each robot to a new one, by track; 0: impossible.
    """
    choices = [
        [(-1, 1.0), *((row, ratio) for row, ratio in enumerate(column) if ratio > 0.0)]
        for column in odds.T.tolist()
    ]
    later, seen = list[int](), 0  # robots that later tracks may be, a bit for each
    for column in reversed(choices):
        later.append(seen)
        seen |= sum(1 << row for row, _ in column[1:])
    later.reverse()
    forward = _forward(choices, later)
    probabilities = np.zeros(odds.shape)
    backward = dict.fromkeys(forward[-1], 1.0)
    for j in reversed(range(len(choices))):
        before, weights = dict[int, float](), dict[int, float]()
        for taken, weight in forward[j].items():
            for row, ratio in choices[j]:
                after = _taken(taken, row, later[j])
                rest = 0.0 if after is None else ratio * backward.get(after, 0.0)
                before[taken] = before.get(taken, 0.0) + rest
                weights[row] = weights.get(row, 0.0) + weight * rest
        whole, most = sum(weights.values()), max(before.values())
        for row, _ in choices[j][1:]:
            probabilities[row, j] = weights[row] / whole
        backward = {taken: weight / most for taken, weight in before.items()}
    return probabilities


def _forward(choices: list[list[tuple[int, float]]], later: list[int]) -> list[dict[int, float]]:
    """Return the weights of the robots taken, by their bits, before each track and after the last.

    Args:
        choices: of each track, robots and likelihood ratios; -1: a new one.
        later: robots that later tracks may be, by track.
    """
    found = [{0: 1.0}]
    for column, kept in zip(choices, later, strict=True):
        sums = dict[int, float]()
        for taken, weight in found[-1].items():
            for row, ratio in column:
                after = _taken(taken, row, kept)
                if after is not None:
                    sums[after] = sums.get(after, 0.0) + weight * ratio
        best = sorted(sums.items(), key=lambda one: -one[1])[: TUNING.most_hypotheses]
        found.append({taken: weight / best[0][1] for taken, weight in best})
    return found


def _taken(taken: int, row: int, kept: int) -> int | None:
    """Return the robots taken with one more, as far as they matter; None: it is taken already."""
    if row < 0:
        return taken & kept
    return None if taken >> row & 1 else (taken | 1 << row) & kept
