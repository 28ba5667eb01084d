# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Average precision over IoU 0.5 to 0.95, as COCO defines it, from boxes and truth in memory.

Definition: T.-Y. Lin et al., "Microsoft COCO", 2014, and its evaluation: boxes are matched greedily
by score, precision is made monotonous and averaged at 101 recalls, for each class and threshold.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.training.labelled import Truth

THRESHOLDS = np.linspace(0.5, 0.95, 10)
RECALLS = np.linspace(0.0, 1.0, 101)
LOWEST_SCORE = 0.001
"""Score threshold for detectors here: the whole precision-recall curve counts."""


@dataclass(frozen=True)
class AveragePrecision:
    """Average precisions of a set of images.

    Attributes:
        table: (classes with a robot that counts, 10), 0 to 1, at IoU 0.5, 0.55 ... 0.95.
        class_ids: (classes,) index of each row's class.
    """

    table: NDArray[np.float64]
    class_ids: NDArray[np.int64]

    @property
    def map50(self) -> float:
        """Mean over classes at IoU 0.5; NaN without any robot."""
        return float(self.table[:, 0].mean()) if self.table.size else float("nan")

    @property
    def map50_95(self) -> float:
        """Mean over classes and IoU thresholds; NaN without any robot."""
        return float(self.table.mean()) if self.table.size else float("nan")


@dataclass(frozen=True)
class Judged:
    """The boxes of one class in one image.

    Attributes:
        scores: (boxes,) from the best.
        outcomes: (10, boxes) at each IoU threshold: 1 right, 0 wrong, NaN neither.
        robots: how many count.
    """

    scores: NDArray[np.float64]
    outcomes: NDArray[np.float64]
    robots: int


def average_precision(pairs: Iterable[tuple[Detections, Truth]]) -> AveragePrecision:
    """Return the average precisions of the boxes of many images against the truth.

    A robot that does not count (too small, too faint, truncated) is neither missed nor detected: a
    box matched to it, or with its centre in it, is ignored, as COCO ignores crowds.

    Args:
        pairs: boxes, found with a score threshold of `LOWEST_SCORE`, and robots of each image.
    """
    return average_of(judge(found, truth) for found, truth in pairs)


def judge(found: Detections, truth: Truth) -> dict[int, Judged]:
    """Return the right and wrong boxes of one image, by class."""
    judged = {}
    for class_id in {*found.class_ids.tolist(), *truth.class_ids.tolist()}:
        boxes, mine = found.class_ids == class_id, truth.class_ids == class_id
        scores, corners = found.scores[boxes], found.xyxy[boxes]
        order = np.argsort(-scores, kind="stable")
        counted = truth.counted[mine]
        outcomes = _outcomes(corners[order], truth.corners[mine], counted)
        judged[class_id] = Judged(scores[order], outcomes, int(counted.sum()))
    return judged


def average_of(images: Iterable[dict[int, Judged]]) -> AveragePrecision:
    """Return the average precisions of judged images."""
    classes: dict[int, list[Judged]] = defaultdict(list)
    for image in images:
        for class_id, judged in image.items():
            classes[class_id].append(judged)
    robots = {c: sum(judged.robots for judged in classes[c]) for c in sorted(classes)}
    class_ids = [class_id for class_id, count in robots.items() if count]
    rows = [_curve_means(classes[class_id], robots[class_id]) for class_id in class_ids]
    table = np.array(rows, dtype=np.float64).reshape(-1, len(THRESHOLDS))
    return AveragePrecision(table, np.array(class_ids, dtype=np.int64))


def _outcomes(
    boxes: NDArray[np.float64], robots: NDArray[np.float64], counted: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return (10, boxes): 1 right, 0 wrong, NaN neither, of boxes sorted by score."""
    result = np.zeros((len(THRESHOLDS), len(boxes)))
    if not len(boxes) or not len(robots):
        return result
    overlap = iou(boxes, robots)
    middles = (boxes[:, None, :2] + boxes[:, None, 2:]) / 2
    inside = ((middles >= robots[:, :2]) & (middles <= robots[:, 2:])).all(axis=2)
    excused: NDArray[np.bool_] = np.any(inside & ~counted, axis=1)
    for row, threshold in zip(result, THRESHOLDS, strict=True):
        free = np.ones(len(robots), dtype=np.bool_)
        for i in range(len(boxes)):
            for mask, outcome in ((counted, 1.0), (~counted, np.nan)):
                possible = np.where(free & mask, overlap[i], -1.0)
                best = int(possible.argmax())
                if possible[best] >= threshold:
                    free[best] = False
                    row[i] = outcome
                    break
            else:
                row[i] = np.nan if excused[i] else 0.0
    return result


def _curve_means(judged: list[Judged], robots: int) -> list[float]:
    """Return the average precision of one class at each IoU threshold."""
    scores = np.concatenate([image.scores for image in judged])
    table = np.concatenate([image.outcomes for image in judged], axis=1)
    order = np.argsort(-scores, kind="stable")
    means = []
    for row in table[:, order]:
        right: NDArray[np.float64] = row[np.isfinite(row)]
        found = np.cumsum(right)
        precision = found / np.arange(1, len(right) + 1)
        best_from_here = np.maximum.accumulate(precision[::-1])[::-1]
        first = np.searchsorted(found / robots, RECALLS, side="left")
        means.append(float(np.append(best_from_here, 0.0)[first].mean()))
    return means
