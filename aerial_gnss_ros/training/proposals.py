# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A detector's boxes with their truth: training data of the second look."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.score import MATCH_IOU

ROOM = 1.25  # views are kept larger, so that they can be turned, moved and scaled
_NEARLY = 0.1  # margin of IoU below which a box is neither fully right nor wrong
_PART_WEIGHT = 0.5
_NEARLY_WEIGHT = 0.3


@dataclass(frozen=True)
class Proposals:
    """Boxes to learn from.

    Attributes:
        views: (n, pixels, pixels, 6) near and wide, `ROOM` times as large as a look.
        traits: (n, 3) as `second_look_terms.traits` gives them.
        scores: (n,) of the detector.
        is_robot: (n,) whether the box fits a robot: IoU 0.5 or more.
        weights: (n,) of each box; boxes that nearly match count little.
    """

    views: NDArray[np.uint8]
    traits: NDArray[np.float32]
    scores: NDArray[np.float64]
    is_robot: NDArray[np.bool_]
    weights: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.scores)

    def times(self, weight: float) -> Proposals:
        """Return the same, each counting `weight` times as much."""
        return Proposals(self.views, self.traits, self.scores, self.is_robot, self.weights * weight)


def joined(parts: Iterable[Proposals]) -> Proposals:
    """Return several sets as one."""
    found = list(parts)
    return Proposals(
        *(np.concatenate([getattr(part, item.name) for part in found])
          for item in fields(Proposals))
    )  # fmt: skip


def gather(detector: Detector, images: Iterable[LabelledImage], terms: Terms) -> Proposals:
    """Return all boxes of a detector in labelled images.

    Certain ones are included, because they also show what robots look like.

    Args:
        detector: with a score threshold of `terms.from_score`, without a second look.
        images: if possible not those of the detector's training, on which it errs less than on
            others.
        terms: of the look.
    """
    pixels = round(terms.side * ROOM)
    made = [_none(pixels)]
    for labelled in images:
        image = labelled.read()
        found = detector.detect(image)
        if len(found):
            is_robot, weights = judged(found.xyxy, labelled.truth)
            made.append(Proposals(
                views(image, found.xywh, terms, ROOM), traits(found.xywh, found.scores),
                found.scores, is_robot, weights,
            ))  # fmt: skip
    return joined(made)


def judged(
    corners: NDArray[np.float64], truth: Truth
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return whether each box (n, 4) is a robot, and its weight."""
    fits = iou(corners, truth.corners).max(axis=1, initial=0.0)
    is_robot = fits >= MATCH_IOU
    middles = (corners[:, None, :2] + corners[:, None, 2:]) / 2
    within = (middles >= truth.corners[:, :2]) & (middles <= truth.corners[:, 2:])
    is_part = np.asarray(within.all(axis=2)).any(axis=1) & ~is_robot
    weights = np.where(is_part, _PART_WEIGHT, 1.0)
    weights[~is_robot & (fits > MATCH_IOU - _NEARLY)] = _NEARLY_WEIGHT
    return is_robot, weights


def _none(pixels: int) -> Proposals:
    return Proposals(
        np.empty((0, pixels, pixels, 6), np.uint8), np.empty((0, 3), np.float32),
        np.empty(0), np.empty(0, np.bool_), np.empty(0),
    )  # fmt: skip
