# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much a second look counts beside the detector: chosen on images that neither learnt from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.second_look_terms import log_odds
from aerial_gnss_ros.training.labelled import Truth
from aerial_gnss_ros.training.score import score_above

_WEIGHTS = tuple(round(0.1 * i, 1) for i in range(1, 11))
_THRESHOLDS = tuple(round(0.05 * i, 2) for i in range(3, 16))


@dataclass(frozen=True)
class Share:
    """How the score of a box that is looked at again comes about; the network's file has it in it.

    The two networks see different things, so each knows what the other does not. Their log odds
    are added, as of independent witnesses, but with weights that sum to 1: they are not.

    Attributes:
        weight: of the second look's log odds; the rest is the first one's.
        shift: is added, so that one threshold suits both.
    """

    weight: float = 1.0
    shift: float = 0.0


@dataclass(frozen=True)
class Look:
    """What was seen in one image.

    Attributes:
        found: by the detector, best first.
        scores: (n,) by the second look.
        truth: the robots.
    """

    found: Detections
    scores: NDArray[np.float64]
    truth: Truth

    def shared(self, weight: float) -> tuple[Detections, Truth]:
        """Return the boxes with their scores mixed: `weight` of the second look's log odds."""
        found = self.found
        odds = weight * log_odds(self.scores) + (1.0 - weight) * log_odds(found.scores)
        mixed = np.where(self.scores == found.scores, found.scores, 1.0 / (1.0 + np.exp(-odds)))
        order = np.argsort(-mixed, kind="stable")
        boxes = Detections(
            found.xywh[order], mixed[order], found.class_ids[order], found.class_names
        )
        return boxes, self.truth


def best_share(groups: Sequence[Sequence[Look]]) -> tuple[Share, float]:
    """Return how much the second look counts, and what is reached so at the default threshold.

    The best is where the lesser of precision and recall is greatest: neither buys the other.

    Args:
        groups: looks at held-out images of several kinds, by a network whose share is all. Each
            kind counts alike, however many images it has.

    Returns:
        The share, and the mean over the kinds of the lesser of precision and recall.

    Raises:
        ModelError: no robot is found in any of them.
    """
    best = (0.0, 1.0, DetectorConfig.score_threshold)
    for weight in _WEIGHTS:
        mixed = [[look.shared(weight) for look in looks] for looks in groups]
        for threshold in _THRESHOLDS:
            reached = float(np.mean([_lesser(pairs, threshold) for pairs in mixed]))
            best = max(best, (reached, weight, threshold))
    reached, weight, threshold = best
    if not reached:
        raise ModelError("on the held-out images no robot is found; give others, with robots.")
    shift = log_odds(DetectorConfig.score_threshold) - log_odds(threshold)
    return Share(weight, float(shift)), reached


def _lesser(pairs: Sequence[tuple[Detections, Truth]], threshold: float) -> float:
    overall = score_above(pairs, threshold).overall
    return overall.found / max(1, overall.robots, overall.found + overall.false)
