# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pairs of a track and a box that may belong together: the lists that `matcher` chooses from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.assignment import likeliest
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.innovation import PairInnovations

Array = NDArray[np.float64]

ROBOT, NEW, NEITHER = "robot", "new", ""
"""Kinds of tracks: robots choose boxes first, new tracks choose from what robots leave, and tracks
that are neither get none."""


@dataclass(frozen=True)
class CandidatePairs:
    """Gating: pairs of an image's boxes with tracks, inside or near their gates.

    Attributes:
        pairs: innovations of k pairs.
        rows: row of each pair's track.
        columns: column of its box.
        squared: its squared Mahalanobis distance.
        log_determinant: log determinant of its innovation covariance.
        kind: of each track, not of each pair.
        threshold: squared Mahalanobis distance at the edge of a gate.
        reach: squared distance up to which a box is just outside a gate.
        robots: pairs of a robot and a box of its class.
        near: those with boxes inside or near the robots' gates.
        inside: those with boxes inside them.
        nearest: pairs of robots with boxes inside or near their gates, nearest first; each robot
            and each box occurs at most once.
        lone: those of a robot and a box that have no other one near, nor a new track that an image
            has shown beside the robot.
        new_near: pairs of a new track and a box of its class inside its gate or near it.
        new_inside: those with boxes inside the gates.
        given: the likeliest assignment of the pairs inside robots' gates.
        left_over: `left` of that.
    """

    pairs: PairInnovations
    rows: list[int]
    columns: list[int]
    squared: list[float]
    log_determinant: list[float]
    kind: list[str]
    threshold: float
    reach: float
    robots: list[int]
    near: list[int]
    inside: list[int]
    nearest: list[int]
    lone: set[int]
    new_near: list[int]
    new_inside: list[int]
    given: list[int]
    left_over: tuple[list[int], int]

    @classmethod
    def of_image(
        cls,
        pairs: PairInnovations,
        distances: tuple[Array, Array],
        kind: list[str],
        tracks: list[Track],
        boxes: list[str],
        threshold: float,
    ) -> CandidatePairs:
        """Classify the pairs of an image.

        Args:
            pairs: innovations of tracks and nearby boxes.
            distances: `mahalanobis` of these.
            kind: of each track.
            tracks: all of them.
            boxes: class of each box.
            threshold: squared distance at the edge of a gate.
        """
        squared, wide = distances[0].tolist(), distances[1].tolist()
        of, to = pairs.rows.tolist(), pairs.columns.tolist()
        reach, every = ASSIGNMENT.near_gate_radii**2 * threshold, list(zip(of, to, strict=True))
        own = _classes(tracks, kind, ROBOT)
        robots = [k for k, (row, column) in enumerate(every) if own[row] == boxes[column]]
        near = [k for k in robots if squared[k] <= reach]
        inside = [k for k in near if squared[k] <= threshold]
        beside: list[int] = []
        if NEW in kind:
            own = _classes(tracks, kind, NEW)
            new = [k for k, (row, column) in enumerate(every) if own[row] == boxes[column]]
            beside = [k for k in new if squared[k] <= reach]
        grown = [k for k in beside if squared[k] <= threshold]
        nearest: list[int] = []
        rows: set[int] = set()
        columns: set[int] = set()
        for k in sorted(near, key=squared.__getitem__):
            if of[k] not in rows and to[k] not in columns:
                rows.add(of[k])
                columns.add(to[k])
                nearest.append(k)
        boxes_of, robots_of = Counter(of[k] for k in near), Counter(to[k] for k in near)
        new_at: dict[int, list[Track]] = {}
        for k in grown:
            new_at.setdefault(to[k], []).append(tracks[of[k]])
        lone = {
            k
            for k in nearest
            if boxes_of[of[k]] == robots_of[to[k]] == 1
            and not any(new.coexisted(tracks[of[k]]) for new in new_at.get(to[k], ()))
        }
        given = _best(of, to, squared, wide, threshold, inside)
        return cls(
            pairs, of, to, squared, wide, kind, threshold, reach, robots, near, inside, nearest,
            lone, beside, grown, given,
            _left(of, to, squared, reach, robots, given, kind.count(ROBOT)),
        )  # fmt: skip

    @property
    def doubtful(self) -> bool:
        """Whether a robot's box may be another one's: gates overlap, or one has no box."""
        return len(self.given) < self.kind.count(ROBOT) or self.contested

    @property
    def contested(self) -> bool:
        """Whether robots' gates overlap, with several robots and boxes in them."""
        rows = {self.rows[k] for k in self.inside}
        columns = {self.columns[k] for k in self.inside}
        return len(self.inside) > max(len(rows), len(columns)) and min(len(rows), len(columns)) > 1

    def with_given(self, given: list[int]) -> CandidatePairs:
        """Return the candidates with another assignment of robots."""
        return replace(self, given=given, left_over=self.left(given))

    def best(self, pairs: list[int]) -> list[int]:
        """Return the likeliest assignment of some pairs inside gates."""
        return _best(
            self.rows, self.columns, self.squared, self.log_determinant, self.threshold, pairs
        )

    def left(self, chosen: list[int]) -> tuple[list[int], int]:
        """Return the pairs of robots and boxes that an assignment leaves over.

        Also returns how many of these robots have a box near their gates.
        """
        known = self.kind.count(ROBOT)
        return _left(self.rows, self.columns, self.squared, self.reach, self.robots, chosen, known)


def _classes(tracks: list[Track], kinds: list[str], kind: str) -> list[str | None]:
    """Return the class of each track of a kind, None for the others."""
    return [
        track.class_id if one is kind else None for track, one in zip(tracks, kinds, strict=True)
    ]


def _best(
    of: list[int],
    to: list[int],
    squared: list[float],
    wide: list[float],
    threshold: float,
    pairs: list[int],
) -> list[int]:
    """Return the likeliest assignment of some pairs, see `CandidatePairs.best`."""
    rows, columns = list(map(of.__getitem__, pairs)), list(map(to.__getitem__, pairs))
    if len({*rows}) == len({*columns}) == len(rows):  # nothing to weigh
        return pairs
    near, log = list(map(squared.__getitem__, pairs)), list(map(wide.__getitem__, pairs))
    return [pairs[k] for k in likeliest(rows, columns, near, log, threshold)]


def _left(
    of: list[int],
    to: list[int],
    squared: list[float],
    reach: float,
    robots: list[int],
    chosen: list[int],
    known: int,
) -> tuple[list[int], int]:
    """Return what an assignment leaves over of `known` robots, see `CandidatePairs.left`."""
    rows, columns = {of[k] for k in chosen}, {to[k] for k in chosen}
    if len(rows) == known:  # each robot has a box, so no pair of a robot is left
        return [], 0
    found: list[int] = []
    missed: set[int] = set()
    for k in robots:
        if of[k] not in rows and to[k] not in columns:
            found.append(k)
            if squared[k] <= reach:
                missed.add(of[k])
    return found, len(missed)
