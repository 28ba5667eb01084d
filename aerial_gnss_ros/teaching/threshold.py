# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chooses the score threshold of a taught detector, for water that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.second_look_terms import score_of
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.score import score_above
from aerial_gnss_ros.training.taught_examples import with_things

THRESHOLDS = tuple(round(float(score_of(0.1 * i)), 4) for i in range(-40, 61))
"""Equal steps of log odds: most scores are near 0 or 1."""
DRAWN = 3
"""Times that other things are drawn into an image."""
_RECALL = 0.5**2  # weight of recall against precision in F0.5
_SHIFT = 20  # of these steps, 2 in log odds: by so much robots score lower on other water


def best_threshold(detector: Detector, images: Sequence[LabelledImage], seed: int) -> float:
    """Return the threshold with the best F measure in the mean over thresholds around it.

    F0.5 (van Rijsbergen 1979): precision counts more, as other water has more to take for a robot,
    and a position of none is worse than none. Of equal ones it is the middle. The mean, as F is
    nearly the same over a wide range, and the best of so few images may be at the end of it, where
    most robots are lost if they score a little lower on other water. Images count as they are, and
    with other things drawn into them, as another place has them.

    Args:
        detector: with the lowest of the thresholds.
        images: labelled, of those that it has learnt from.
        seed: of what is drawn.
    """
    rng = np.random.default_rng(seed)
    pairs = []
    for image in images:
        seen = image.read(), image.truth
        frames = [seen, *(with_things(rng, seen) for _ in range(DRAWN))]
        pairs += [(detector.detect(shown), truth) for shown, truth in frames]
    reached = []
    for threshold in THRESHOLDS:
        tally = score_above(pairs, threshold).overall
        boxes = tally.found + tally.false
        reached.append((1.0 + _RECALL) * tally.found / max(1.0, _RECALL * tally.robots + boxes))
    around = np.ones(2 * _SHIFT + 1) / (2 * _SHIFT + 1)
    means = np.convolve(np.pad(reached, _SHIFT, mode="edge"), around, mode="valid")
    best = np.flatnonzero(np.isclose(means, means.max()))
    return THRESHOLDS[int(best[len(best) // 2])]
