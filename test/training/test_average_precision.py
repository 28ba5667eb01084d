# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Average precision against a table worked out by hand, and against COCO's own program."""

from __future__ import annotations

import contextlib
import io

import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.average_precision import average_precision
from aerial_gnss_ros.training.labelled import Truth


def found(boxes: list[tuple[float, ...]]) -> Detections:
    """Detections from rows of left, top, width, height, score, class."""
    table = np.array(boxes, dtype=float).reshape(-1, 6)
    xywh = np.hstack([table[:, :2] + table[:, 2:4] / 2, table[:, 2:4]])
    return Detections(xywh, table[:, 4], table[:, 5].astype(np.int64), ("a", "b", "c"))


def truth(robots: list[tuple[float, ...]], uncounted: tuple[int, ...] = ()) -> Truth:
    """Robots from rows of left, top, width, height, class."""
    table = np.array(robots, dtype=float).reshape(-1, 5)
    corners = np.hstack([table[:, :2], table[:, :2] + table[:, 2:4]])
    counted = np.array([i not in uncounted for i in range(len(table))], dtype=np.bool_)
    classes = table[:, 4].astype(np.int64)
    return Truth(corners, counted, table[:, 2:4].max(axis=1, initial=0), counted * 1.0, classes)


ROBOT = (0, 0, 100, 100, 0)
SHIFTED = (0, 0, 100, 62, 0.9, 0)  # IoU 0.62: right at 0.5, 0.55 and 0.6, wrong at seven others
EXACT = (0, 0, 100, 100, 0.9, 0)
FALSE = (500, 500, 20, 20, 0.95, 0)


@pytest.mark.parametrize(
    ("boxes", "robots", "uncounted", "map50", "map50_95"),
    [
        ([EXACT], [ROBOT], (), 1.0, 1.0),
        ([SHIFTED], [ROBOT], (), 1.0, 0.3),
        ([], [ROBOT], (), 0.0, 0.0),
        # One false box before the right one: precision 1/2 at every recall.
        ([FALSE, EXACT], [ROBOT], (), 0.5, 0.5),
        # One of two robots: precision 1 at the 51 recalls 0, 0.01 ... 0.5 of 101.
        ([EXACT], [ROBOT, (300, 300, 50, 50, 0)], (), 51 / 101, 51 / 101),
        # The second robot does not count: nothing is missed, and a box on it is not false.
        ([EXACT, (300, 300, 50, 50, 0.99, 0)], [ROBOT, (300, 300, 50, 50, 0)], (1,), 1.0, 1.0),
        ([EXACT, (310, 310, 9, 9, 0.99, 0)], [ROBOT, (300, 300, 50, 50, 0)], (1,), 1.0, 1.0),
        # Found twice: the second box is false, but after all robots are found it costs nothing.
        ([EXACT, (0, 0, 100, 100, 0.5, 0)], [ROBOT], (), 1.0, 1.0),
        # Another class is another matter: class 0 missed, class 1 has no robot.
        ([(0, 0, 100, 100, 0.9, 1)], [ROBOT], (), 0.0, 0.0),
    ],
)
def test_by_hand(boxes, robots, uncounted, map50, map50_95):
    result = average_precision([(found(boxes), truth(robots, uncounted))])
    assert result.map50 == pytest.approx(map50)
    assert result.map50_95 == pytest.approx(map50_95)


def test_images_share_one_curve_and_an_empty_set_has_no_figure():
    pairs = [(found([EXACT]), truth([ROBOT])), (found([FALSE]), truth([]))]
    assert average_precision(pairs).map50 == pytest.approx(0.5)
    assert np.isnan(average_precision([(found([]), truth([]))]).map50_95)


def test_as_coco_s_own_program():
    coco_module = pytest.importorskip("pycocotools.coco", reason="pip install '.[test]'")
    from pycocotools.cocoeval import COCOeval

    rng = np.random.default_rng(5)
    pairs, annotations, results = [], [], []
    for image in range(40):
        robots = [(*rng.uniform(0, 300, 2), *rng.uniform(20, 90, 2), int(rng.integers(3)))
                  for _ in range(rng.integers(0, 6))]  # fmt: skip
        boxes = [(*rng.uniform(0, 300, 2), *rng.uniform(20, 90, 2), rng.uniform(), 0)
                 for _ in range(rng.integers(0, 4))]  # fmt: skip
        for robot in robots * 2:
            moved = np.array(robot[:4]) * rng.normal(1.0, 0.06, 4)
            seen_as = robot[4] if rng.uniform() < 0.9 else int(rng.integers(3))
            boxes.append((*moved, rng.uniform(), seen_as))
        pairs.append((found(boxes), truth(robots)))
        annotations += [
            {"id": len(annotations) + k + 1, "image_id": image, "category_id": r[4] + 1,
             "bbox": list(r[:4]), "area": r[2] * r[3], "iscrowd": 0}
            for k, r in enumerate(robots)
        ]  # fmt: skip
        results += [
            {"image_id": image, "category_id": b[5] + 1, "bbox": list(b[:4]), "score": b[4]}
            for b in boxes
        ]
    with contextlib.redirect_stdout(io.StringIO()):
        coco = coco_module.COCO()
        coco.dataset = {
            "info": {}, "annotations": annotations, "images": [{"id": i} for i in range(40)],
            "categories": [{"id": i} for i in (1, 2, 3)],
        }  # fmt: skip
        coco.createIndex()
        evaluation = COCOeval(coco, coco.loadRes(results), "bbox")
        evaluation.evaluate()
        evaluation.accumulate()
        evaluation.summarize()
    ours = average_precision(pairs)
    assert 0.1 < ours.map50_95 < ours.map50 < 0.9  # neither trivial nor equal
    assert ours.map50_95 == pytest.approx(evaluation.stats[0], abs=1e-9)
    assert ours.map50 == pytest.approx(evaluation.stats[1], abs=1e-9)
