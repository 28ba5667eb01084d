# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Uncertainty of scores by resampling test scenes (bootstrap, B. Efron 1979).

Images of one scene share light, water and camera, so scenes are resampled, not images. Every
detector gets the same resamples, so scores of two detectors are compared pairwise, which cancels
the difficulty of a resample.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.average_precision import average_of, judge
from aerial_gnss_ros.training.labelled import Truth
from aerial_gnss_ros.training.score import above, match

FIGURES = ("map50", "map50_95", "precision", "recall")


def draws(images: int, scene: int, times: int, seed: int = 0) -> list[NDArray[np.int64]]:
    """Return indices of images, once for each draw: as many scenes as there are, with replacement.

    Args:
        images: number of images; consecutive ones are of one scene.
        scene: number of images per scene.
        times: number of draws.
        seed: equal seeds, equal draws.
    """
    rng = np.random.default_rng(seed)
    scenes = np.array_split(np.arange(images), np.arange(scene, images, scene))
    return [
        np.concatenate([scenes[i] for i in rng.integers(len(scenes), size=len(scenes))])
        for _ in range(times)
    ]


def figures_of_draws(
    pairs: Sequence[tuple[Detections, Truth]],
    picks: Sequence[NDArray[np.int64]],
    score_threshold: float,
) -> dict[str, NDArray[np.float64]]:
    """Return each of `FIGURES` for each draw.

    Args:
        pairs: boxes, found with a score threshold of `LOWEST_SCORE`, and robots of each image.
        picks: indices of the images of each draw.
        score_threshold: of the boxes that precision and recall count.
    """
    judged = [judge(found, truth) for found, truth in pairs]
    counts = np.array([_counts(above(f, score_threshold), truth) for f, truth in pairs])
    rows = []
    for pick in picks:
        whole = average_of(judged[i] for i in pick)
        robots, found, false = counts[pick].sum(axis=0)
        rows.append(
            (whole.map50, whole.map50_95, found / max(1, found + false), found / max(1, robots))
        )
    return dict(zip(FIGURES, np.array(rows, dtype=np.float64).T, strict=True))


def _counts(found: Detections, truth: Truth) -> tuple[int, int, int]:
    """Return the numbers of robots that count, of detected ones, and of false boxes."""
    matched = match(found, truth)
    wrong = int((matched.robot == -1).sum())
    return int(truth.counted.sum()), int((matched.robot >= 0).sum()), wrong
