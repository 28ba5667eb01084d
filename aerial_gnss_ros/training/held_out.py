# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Held-out images, on which a training is scored."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.average_precision import average_precision
from aerial_gnss_ros.training.compare import for_scoring
from aerial_gnss_ros.training.inspection import Example, Inspection
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_folder
from aerial_gnss_ros.training.score import score_above

META = "meta.csv"
THRESHOLDS = np.round(np.arange(0.05, 1.0, 0.05), 2)
ABOUT_AS_GOOD = 0.002


def held_out_split(found: Inspection) -> str:
    """Return `test` if the data set has it, else `val`, which chose the best epoch."""
    return "test" if found.examples.get("test") else "val"


def held_out_images(found: Inspection, split: str) -> Iterator[LabelledImage]:
    """Yield the images of a split, with the simulation's records if they are simulated."""
    root = found.dataset.root
    folders = found.dataset.folders.get(split, ())
    if (root / META).is_file() and list(folders) == [root / "images" / split]:
        yield from read_folder(root, split)
        return
    for example in found.examples[split]:
        yield LabelledImage(example.image.name, _truth(example), partial(read_image, example.image))


def score_weights(
    weights: Path, images: Iterator[LabelledImage], config: DetectorConfig
) -> dict[str, Any]:
    """Return the scores of weights as figures for JSON.

    Args:
        weights: made by this program; a .pt is loaded without confirmation.
        images: to score on.
        config: score threshold, image size and device.
    """
    low = for_scoring(replace(config, model=str(weights), allow_pickle=True))
    detector = load_detector(low)
    pairs = []
    for image in images:
        found = detector.detect(image.read())
        pairs.append((found, image.truth))
    result = score_above(pairs, config.score_threshold)
    precision = average_precision(pairs)
    threshold, f1 = best_threshold(pairs)
    return {
        **result.as_dict(),
        "map50": precision.map50,
        "map50_95": precision.map50_95,
        "score_threshold": config.score_threshold,
        "best_score_threshold": threshold,
        "best_f1": f1,
    }


def best_threshold(pairs: Sequence[tuple[Detections, Truth]]) -> tuple[float, float]:
    """Return the score threshold with the best F1 score, and that score.

    Of several that are about equally good, the middle one, which is the most robust. NaN if no
    robot is detected at any.
    """
    f1 = np.zeros(len(THRESHOLDS))
    for i, threshold in enumerate(THRESHOLDS):
        overall = score_above(pairs, float(threshold)).overall
        # 2 P R / (P + R), from the counts.
        f1[i] = 2 * overall.found / max(1, overall.robots + overall.found + overall.false)
    if not f1.max():
        return float("nan"), float("nan")
    good = np.flatnonzero(f1 >= f1.max() - ABOUT_AS_GOOD)
    return float(THRESHOLDS[good[len(good) // 2]]), float(f1.max())


def _truth(example: Example) -> Truth:
    size = np.array(example.size, dtype=np.float64)
    centre, extent = example.boxes[:, :2] * size - 0.5, example.boxes[:, 2:] * size
    count = len(example.boxes)
    return Truth(
        np.hstack([centre - extent / 2, centre + extent / 2]),
        np.ones(count, dtype=np.bool_),
        extent.max(axis=1, initial=0.0),
        np.full(count, np.nan),
        example.classes,
    )
