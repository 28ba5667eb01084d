# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rows of what `unseen_water.py` prints: false boxes on photographs, and robots found."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.second_look_terms import score_of
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.training.labelled import Truth
from aerial_gnss_ros.training.photographs import water_of
from aerial_gnss_ros.training.picture_labels import PictureLabels
from aerial_gnss_ros.training.score import MATCH_IOU, Score

SOURCES = {"northsea_video": 1.0, "lake_nadir": 1.0, "lake_shore": 0.5}
"""Name of each, and the share of its photographs that is taken for water."""
LENGTH_PX = 24.0  # of robots that a detector is expected to find on real water
QUANTILES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0)
"""At which scores are told; `false_robots.py` draws scores by them."""
THRESHOLDS = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


def above(found: Detections, threshold: float) -> Detections:
    """Return the boxes from a score on."""
    kept = found.scores >= threshold
    return Detections(
        found.xywh[kept], found.scores[kept], found.class_ids[kept], found.class_names
    )


def in_area(folder: Path, made: Sequence[Any]) -> list[Any]:
    """Return what was found in the part of each photograph that is taken for water.

    It stands in for an area of operation, since these photographs have no telemetry.
    """
    kept = []
    for name, found, truth in made:
        image = read_image(folder / "images" / name)
        water = water_of(image, SOURCES[folder.name])
        size = np.array(water.shape[::-1])
        columns, rows = np.clip(np.round(found.xywh[:, :2]).astype(int), 0, size - 1).T
        chosen = water[rows, columns]
        inside = Detections(
            found.xywh[chosen], found.scores[chosen], found.class_ids[chosen], found.class_names
        )
        kept.append((name, inside, truth))
    return kept


def on_what(found: Detections, labels: Any, name: str) -> list[str]:
    """Return the class of what each box lies on; nothing labelled: `other`."""
    known = labels.of(name, (0, 0))
    if known is None or not len(known.corners):
        return ["other"] * len(found)
    fits = iou(found.xyxy, known.corners)
    return [known.classes[row.argmax()] if row.max() > 0.1 else "other" for row in fits]


def false_boxes(folder: Path, made: Sequence[Any]) -> str:
    """Return a row: false boxes an image on a source's photographs at each threshold."""
    labels = PictureLabels(folder / "labels.csv", ())
    counts = [sum(len(above(found, t)) for _, found, _ in made) for t in THRESHOLDS]
    kinds = Counter(
        kind for name, found, _ in made for kind in on_what(above(found, 0.3), labels, name)
    )
    cells = " | ".join(f"{count / len(made):.3f}" for count in counts)
    return f"| {folder.name} | {len(made)} | {cells} | {dict(kinds.most_common())} |"


def robots(source: str, made: Sequence[Any]) -> str:
    """Return a row: robots composed onto a source's photographs that are found."""
    scores = [recall_of(made, threshold) for threshold in THRESHOLDS]
    cells = [f"{one.overall.recall:.3f}, {one.overall.false / len(made):.2f}" for one in scores]
    return f"| {source} | {scores[0].overall.robots} | {' | '.join(cells)} |"


def recall_of(made: Sequence[Any], threshold: float) -> Score:
    """Return the score of robots that are long enough, from a score on."""
    score = Score()
    for _, found, truth in made:
        long_enough = truth.counted & (truth.long_px >= LENGTH_PX)
        score.add(
            above(found, threshold),
            Truth(truth.corners, long_enough, truth.long_px, truth.contrast, truth.class_ids),
        )
    return score


def threshold_at(with_robots: Sequence[Any], least: float) -> float:
    """Return the highest threshold at which a share of the robots is found; NaN: none is."""
    low, high = -10.0, 10.0  # log odds of thresholds at which enough and too few are found
    if recall_of(with_robots, float(score_of(low))).overall.recall < least:
        return math.nan
    while high - low > 0.005:
        middle = (low + high) / 2.0
        score = recall_of(with_robots, float(score_of(middle)))
        low, high = (middle, high) if score.overall.recall >= least else (low, middle)
    return float(score_of(low))


def at_recall(
    folder: Path, plain: Sequence[Any], with_robots: Sequence[Any], shares: Sequence[float]
) -> str:
    """Return a row: false boxes an image where shares of robots are found."""
    thresholds = [threshold_at(with_robots, least) for least in shares]
    counts = [sum(len(above(found, t)) for _, found, _ in plain) / len(plain) for t in thresholds]
    cells = ["-" if math.isnan(t) else f"{n:.3f}" for t, n in zip(thresholds, counts, strict=True)]
    return f"at {shares} found: | {folder.name} | {' | '.join(cells)} |"


def by_kind(folder: Path, plain: Sequence[Any], with_robots: Sequence[Any]) -> Iterator[str]:
    """Yield what false boxes are on at the default threshold, with their scores, and robots'."""
    for kind, scores in _scores_by_kind(folder, plain, with_robots).items():
        quantiles = " | ".join(f"{one:.2f}" for one in np.quantile(scores, QUANTILES))
        yield f"{kind}: {len(scores) / len(plain):.2f} an image; scores {quantiles}"


def _scores_by_kind(
    folder: Path, plain: Sequence[Any], with_robots: Sequence[Any]
) -> dict[str, list[float]]:
    """Return the scores of false boxes by what they are on, and of robots."""
    labels = PictureLabels(folder / "labels.csv", ())
    scores: dict[str, list[float]] = defaultdict(list)
    for name, found, _ in plain:
        some = above(found, DetectorConfig.score_threshold)
        for kind, score in zip(on_what(some, labels, name), some.scores.tolist(), strict=True):
            scores[kind].append(score)
    for _, found, truth in with_robots:
        some = above(found, DetectorConfig.score_threshold)
        robots = truth.corners[truth.long_px >= LENGTH_PX]
        if len(some) and len(robots):
            hit = iou(some.xyxy, robots).max(axis=1) > MATCH_IOU
            scores["robot"] += some.scores[hit].tolist()
    return dict(sorted(scores.items(), key=lambda one: -len(one[1])))
