# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Label probabilities of tracked image points, and their evidence for detections."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE
from aerial_gnss_ros.core.models.evidence import UNCLEAR

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ImageLabelsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    unmodelled_probability: float = 0.01
    """Probability that links fail in a way not modelled. Judged."""


TUNING = ImageLabelsTuning()

UNMODELLED_COST = -2.0 * math.log(TUNING.unmodelled_probability)
"""Minus twice the log of that probability."""


class LabelEvidence(NamedTuple):
    """Evidence of the image for a detection's label, as likelihood factors.

    Attributes:
        names: by label of a tracked robot.
        others: of any other robot.
    """

    names: dict[str, float]
    others: float

    def factor(self, name: str) -> float:
        """Return the likelihood factor of a robot."""
        return max(self.names.get(name, self.others), TUNING.unmodelled_probability)

    def renamed(self, names: Mapping[str, str]) -> LabelEvidence:
        """Return the evidence with other labels: new ones by old ones; others stay."""
        return self._replace(names={names.get(one, one): p for one, p in self.names.items()})

    def contradicts(self, name: str) -> bool:
        """Return whether the detection is clearly another one of the tracked robots."""
        return self.names.get(name, 1.0) < UNCLEAR and max(self.names.values()) > 1.0 - UNCLEAR


NO_EVIDENCE = LabelEvidence({}, 1.0)
"""No evidence."""


class Point(NamedTuple):
    """A point of the image that is tracked.

    Attributes:
        place: (x, y) in the last image, on the plane at distance 1.
        class_id: of its box.
        names: probability of each label.
        seen_ns: of the last image that showed it.
        spread: variance of its position beyond that of a box and its own motion.
        there: probability that it exists; the sum of `names` is at most this.
    """

    place: tuple[float, float]
    class_id: str
    names: dict[str, float]
    seen_ns: int
    spread: float = 0.0
    there: float = 1.0


def label_probabilities(points: list[Point], chances: Array) -> list[dict[str, float]]:
    """Return the label probabilities of each detection by itself.

    Args:
        points: (n,) tracked points.
        chances: (n, m) of each to be each detection.
    """
    found: list[dict[str, float]] = []
    for of_points in chances.T.tolist():
        names: dict[str, float] = {}
        for one, chance in zip(points, of_points, strict=True):
            for name, p in one.names.items():
                names[name] = names.get(name, 0.0) + p / one.there * chance
        found.append(names)
    return found


def once_each(
    points: list[Point], known: tuple[str, ...], found: list[dict[str, float]]
) -> dict[str, float]:
    """Return factors that normalise each label over all points and its loss."""
    factors = {}
    for name in known:
        lost = max(0.0, 1.0 - sum(one.names.get(name, 0.0) for one in points))
        factors[name] = 1.0 / max(
            lost + sum(one.get(name, 0.0) for one in found), EVIDENCE.forgotten
        )
    return factors


def labels_of(points: list[Point], known: tuple[str, ...]) -> dict[int, LabelEvidence]:
    """Return the evidence for an image's boxes, each of which is a point.

    A box without a linked predecessor may be any robot that was lost.
    """
    lost = {name: max(0.0, 1.0 - sum(one.names.get(name, 0.0) for one in points)) for name in known}
    found = {}
    for index, one in enumerate(points):
        unknown = max(0.0, 1.0 - sum(one.names.values()))
        names = {name: one.names.get(name, 0.0) + unknown * lost[name] for name in known}
        found[index] = LabelEvidence(names, unknown)
    return found


def scaled(names: dict[str, float], factors: dict[str, float]) -> dict[str, float]:
    """Return probabilities times a factor for each label, without negligible ones."""
    scaled = {name: p * factors[name] for name, p in names.items()}
    return {name: p for name, p in scaled.items() if p > EVIDENCE.forgotten}
