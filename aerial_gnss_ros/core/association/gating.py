# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pairs of a track and a box that may belong together: the lists that `matcher` chooses from."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.assignment import likeliest
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

ROBOT, NEW, NEITHER = "robot", "new", ""
"""Kinds of tracks: a single box updates a robot, a new track grows up on boxes that robots leave,
and one that is neither gets none."""


@dataclass(frozen=True)
class CandidatePairs:
    """Pairs of an image, those that can be apart from those that are only near.

    Attributes:
        of: row of each pair's track.
        to: column of its box.
        squared: its squared Mahalanobis distance.
        wide: log determinant of the covariance that it was taken with.
        kind: of each track, not of each pair.
        threshold: squared distance at the edge of a gate.
        alike: pairs of one class whose track may have a box.
        robots: those of robots.
        grown: those of new tracks, with boxes inside their gates.
    """

    of: list[int]
    to: list[int]
    squared: list[float]
    wide: list[float]
    kind: list[str]
    threshold: float
    alike: list[int]
    robots: list[int]
    grown: list[int]

    @classmethod
    def of_image(
        cls,
        pairs: PairInnovations,
        kind: list[str],
        tracks: list[str],
        boxes: list[str],
        threshold: float,
    ) -> CandidatePairs:
        """Take the pairs of an image.

        Args:
            pairs: tracks and boxes that are near one another.
            kind: of each track.
            tracks: class of each track.
            boxes: class of each box.
            threshold: squared distance at the edge of a gate.
        """
        distances, log_determinant = mahalanobis(pairs.offsets, pairs.spread)
        squared = distances.tolist()
        of, to = pairs.rows.tolist(), pairs.columns.tolist()
        alike = [
            k
            for k, (row, column) in enumerate(zip(of, to, strict=True))
            if kind[row] and tracks[row] == boxes[column]
        ]
        robots = [k for k in alike if kind[of[k]] is ROBOT]
        grown = [k for k in alike if kind[of[k]] is NEW and squared[k] <= threshold]
        wide = log_determinant.tolist()
        return cls(of, to, squared, wide, kind, threshold, alike, robots, grown)

    @property
    def inside(self) -> list[int]:
        """Pairs of robots with boxes inside their gates."""
        return [k for k in self.robots if self.squared[k] <= self.threshold]

    @property
    def log(self) -> list[float]:
        """Log likelihood of each pair, but for a constant."""
        return [-0.5 * (near + area) for near, area in zip(self.squared, self.wide, strict=True)]

    def best(self, pairs: list[int]) -> list[int]:
        """Return those of some pairs that are the likeliest assignment."""
        found = likeliest(
            [self.of[k] for k in pairs],
            [self.to[k] for k in pairs],
            [self.squared[k] for k in pairs],
            [self.wide[k] for k in pairs],
            self.threshold,
        )
        return [pairs[k] for k in found]

    def left(self, chosen: list[int]) -> list[int]:
        """Return the pairs of robots and boxes that some chosen pairs leave over."""
        rows, columns = {self.of[k] for k in chosen}, {self.to[k] for k in chosen}
        return [k for k in self.robots if self.of[k] not in rows and self.to[k] not in columns]

    def near(self, pairs: list[int]) -> list[int]:
        """Return those of some pairs that are inside or just outside a gate."""
        return [
            k for k in pairs if self.squared[k] <= ASSIGNMENT.near_gate_radii**2 * self.threshold
        ]
