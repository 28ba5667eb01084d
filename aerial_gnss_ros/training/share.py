# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Weight of the second look relative to the detector, chosen on images used to train neither."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.second_look_terms import log_odds, score_of
from aerial_gnss_ros.training.labelled import Truth
from aerial_gnss_ros.training.score import score_above

_WEIGHTS = tuple(round(0.1 * i, 1) for i in range(1, 11))
_THRESHOLDS = tuple(round(0.05 * i, 2) for i in range(3, 16))
_FINE = tuple(round(0.02 * i, 2) for i in range(1, 50))


@dataclass(frozen=True)
class Share:
    """Combination of both scores of a rescored box, stored in the network's file.

    The two networks have different inputs, so their scores are complementary. Their log odds are
    added with weights that sum to 1, because they are not independent.

    Attributes:
        weight: of the second look's log odds; the detector's have the rest.
        shift: added to log odds, so that one threshold suits both.
    """

    weight: float = 1.0
    shift: float = 0.0

    def scores(
        self, second: NDArray[np.float64], first_odds: NDArray[np.floating[Any]]
    ) -> NDArray[np.float64]:
        """Return the combined scores (n,).

        Args:
            second: (n,) scores by the second look.
            first_odds: (n,) log odds by the detector.
        """
        odds = self.weight * log_odds(second) + (1.0 - self.weight) * first_odds
        return score_of(odds + self.shift)


@dataclass(frozen=True)
class Look:
    """Boxes of one image with both scores.

    Attributes:
        found: by the detector, best first.
        scores: (n,) by the second look.
        truth: the robots.
    """

    found: Detections
    scores: NDArray[np.float64]
    truth: Truth

    def shared(self, weight: float) -> tuple[Detections, Truth]:
        """Return the boxes with combined scores: `weight` of the second look's log odds."""
        found = self.found
        both = Share(weight).scores(self.scores, log_odds(found.scores))
        mixed = np.where(self.scores == found.scores, found.scores, both)
        order = np.argsort(-mixed, kind="stable")
        boxes = Detections(
            found.xywh[order], mixed[order], found.class_ids[order], found.class_names
        )
        return boxes, self.truth


def best_share(groups: Sequence[Sequence[Look]]) -> tuple[Share, float]:
    """Return the best combination, and its score at the default threshold.

    The best one maximises the lesser of precision and recall, so neither is traded for the other.

    Args:
        groups: looks at held-out images of several kinds, by a network with weight 1. All kinds
            have equal weight, whatever their numbers of images.

    Returns:
        The share, and the mean over the kinds of the lesser of precision and recall.

    Raises:
        ModelError: no robot is detected in any of them.
    """
    best = (0.0, 1.0, DetectorConfig.score_threshold)
    for weight in _WEIGHTS:
        mixed = [[look.shared(weight) for look in looks] for looks in groups]
        for threshold in _THRESHOLDS:
            reached = float(np.mean([_lesser(pairs, threshold) for pairs in mixed]))
            best = max(best, (reached, weight, threshold))
    reached, weight, threshold = best
    if not reached:
        raise ModelError("on the held-out images no robot is detected; give others, with robots.")
    shift = log_odds(DetectorConfig.score_threshold) - log_odds(threshold)
    return Share(weight, float(shift)), reached


def strictest_share(
    groups: Sequence[Sequence[Look]],
    least_recall: Sequence[float],
    weights: Sequence[float] = _WEIGHTS,
) -> tuple[Share, float]:
    """Return the combination with the fewest false boxes that still detects enough robots.

    For a detector on whose boxes people act: a false box is worse than a miss. For every weight the
    threshold is as high as the required recalls allow.

    Args:
        groups: looks at held-out images of several kinds, by a network with weight 1.
        least_recall: required on each kind, 0 to 1.
        weights: of the second look, to choose from.

    Returns:
        The share, and the mean over the kinds of the false boxes an image.

    Raises:
        ModelError: no combination detects so many.
    """
    best: tuple[float, float, float] | None = None
    for weight in weights:
        mixed = [[look.shared(weight) for look in looks] for looks in groups]
        for threshold in reversed(_FINE):
            scores = [score_above(pairs, threshold).overall for pairs in mixed]
            enough = zip(scores, least_recall, strict=True)
            if all(score.found >= least * score.robots for score, least in enough):
                counted = zip(scores, mixed, strict=True)
                false = float(np.mean([score.false / len(pairs) for score, pairs in counted]))
                best = min(best or (np.inf, 0.0, 0.0), (false, weight, threshold))
                break
    if best is None:
        raise ModelError("no combination of both scores detects so many robots; ask for fewer.")
    false, weight, threshold = best
    shift = log_odds(DetectorConfig.score_threshold) - log_odds(threshold)
    return Share(weight, float(shift)), false


def _lesser(pairs: Sequence[tuple[Detections, Truth]], threshold: float) -> float:
    overall = score_above(pairs, threshold).overall
    return overall.found / max(1, overall.robots, overall.found + overall.false)
