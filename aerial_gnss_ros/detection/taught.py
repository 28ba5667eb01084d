# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects the robots that `aerial-gnss teach` was shown, among all that is unlike the water.

Proposals of the detector `anomaly`, drawn tightly around what stands out, are told apart by a small
network: regions with features of a convolutional network (Girshick et al., CVPR 2014), where
regions come from the water and not from the picture.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.anomaly import ANOMALY, AnomalyDetector
from aerial_gnss_ros.detection.base import Detections, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.outline import outlined
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.detection.yolo import iou

TERMS = Terms(from_score=0.1, to_score=1.0, most=64, parts=True)
"""Of the networks that `teach` trains: faint things too, as the network is what decides. What is
whole on the water of the recording may stand out only in parts on other water."""
_AROUND = (1.0, 2.5)
"""Sizes of the surroundings of an anomaly, its sides, in which an outline is searched."""
_NEIGHBOURS = 1.2
"""Gap between two anomalies, sums of their longer sides, up to which both may be of one robot."""
_MOST_PAIRS = 40
_SAME = 0.7
"""Overlap (intersection over union) above which two outlines are one."""
_PART = 0.5
"""Share of the smaller of two boxes above which both are of one robot."""
_TO_MIDDLES = np.array([0.5, 0.5, 0.0, 0.0])  # from coordinates of pixel edges to pixel centres


class Proposer:
    """Finds what may be a robot.

    Of some robots only parts stand out from the water (a white nose, an orange stripe). Where the
    terms say so, the outline of what lies around each anomaly, and the box around two neighbours,
    are proposals, too; the network decides. They take twice the time.

    Args:
        terms: least score and greatest number of the anomalies.
        iou_threshold: of two boxes that overlap more than this, the better one is kept.
    """

    def __init__(self, terms: Terms, iou_threshold: float = DetectorConfig.iou_threshold) -> None:
        self._around = _AROUND if terms.parts else _AROUND[:1]
        self._parts, self._overlap = terms.parts, _SAME if terms.parts else iou_threshold
        self._anomaly = AnomalyDetector(
            DetectorConfig(
                model=ANOMALY, score_threshold=terms.from_score, max_detections=terms.most
            )
        )

    def detect(self, image: Image) -> Detections:
        """Return the boxes, each around an outline, those of the best scores first."""
        found = self._anomaly.detect(image)
        boxes, index, own = [], [], []
        for i, box in enumerate(found.xywh):
            for factor in self._around:
                rough = box * (1.0, 1.0, factor, factor) + _TO_MIDDLES
                outline = outlined(image, rough)
                if outline is not None or factor == 1.0:
                    boxes.append((rough if outline is None else outline) - _TO_MIDDLES)
                    index.append(i)
                if factor == 1.0:
                    own.append(boxes[-1])
        for i, j, union in _pairs(np.array(own).reshape(-1, 4)) if self._parts else ():
            boxes.append(union)
            index.append(max(i, j))  # the weaker one
        xywh = np.array(boxes, dtype=np.float64).reshape(-1, 4)
        chosen = np.array(index, dtype=np.int64)
        drawn = replace(
            found, xywh=xywh, scores=found.scores[chosen], class_ids=found.class_ids[chosen]
        )
        shared = iou(drawn.xyxy, drawn.xyxy)
        kept: list[int] = []
        for i in range(len(drawn)):  # several anomalies may have one outline
            if (shared[i, kept] <= self._overlap).all():
                kept.append(i)
        return replace(
            drawn, xywh=xywh[kept], scores=drawn.scores[kept], class_ids=drawn.class_ids[kept]
        )


def _pairs(boxes: NDArray[np.float64]) -> list[tuple[int, int, NDArray[np.float64]]]:
    """Return neighbours among boxes (n, 4), the strongest first, with the box around both.

    A robot of the water's colour with a bright bow and stern is two anomalies (grouping of regions:
    Uijlings et al., "Selective search for object recognition", IJCV 2013).
    """
    low, high = boxes[:, :2] - boxes[:, 2:] / 2.0, boxes[:, :2] + boxes[:, 2:] / 2.0
    long = boxes[:, 2:].max(axis=1, initial=0.0)
    found = []
    for j in range(len(boxes)):
        gap = np.maximum(np.maximum(low[:j] - high[j], low[j] - high[:j]), 0.0)
        near = np.linalg.norm(gap, axis=1) <= _NEIGHBOURS * (long[:j] + long[j])
        for i in np.flatnonzero(near & (gap.max(axis=1, initial=0.0) > 0.0)):
            start, end = np.minimum(low[i], low[j]), np.maximum(high[i], high[j])
            found.append((int(i), j, np.concatenate([(start + end) / 2.0, end - start])))
    return found[:_MOST_PAIRS]


class TaughtDetector:
    """Detects the robots that a network was taught.

    Args:
        config: thresholds, and names that replace the network's.
        second: the network.

    Raises:
        ConfigError: a search mode, which does not apply, or another number of class names.
        ModelError: the network knows no classes: it was trained for another detector.
    """

    def __init__(self, config: DetectorConfig, second: SecondLook) -> None:
        AnomalyDetector(replace(config, class_names=()))  # refuses what does not apply to it
        names = second.terms.class_names
        if not names:
            raise ModelError(
                f"{second.name} rescores boxes of another detector; with the model {ANOMALY} give "
                "a network that aerial-gnss teach has trained, or set second_look to off."
            )
        if config.class_names and len(config.class_names) != len(names):
            raise ConfigError(
                f"class_names has {len(config.class_names)} names, but {second.name} knows "
                f"{len(names)} classes ({', '.join(names)}); give as many, or none."
            )
        self.class_names = config.class_names or names
        self.name = f"taught {second.name}, on boxes of {ANOMALY}"
        self._config, self._second = config, second
        self._proposer = Proposer(second.terms, config.iou_threshold)

    def detect(self, image: Image) -> Detections:
        """Return the robots of an image, best score first.

        Raises:
            ModelError: the runtime failed; the next image may succeed.
        """
        began = time.perf_counter()
        found = self._proposer.detect(image)
        scores, classes = np.zeros(0), np.zeros(0, np.int64)
        if len(found):
            shown = views(image, found.xywh, self._second.terms)
            table = self._second.run(shown, traits(found.xywh, found.scores))
            scores, classes = table.max(axis=1), table.argmax(axis=1)
        order = np.argsort(-scores, kind="stable")
        order = order[scores[order] >= self._config.score_threshold]
        if self._second.terms.parts:
            order = order[_distinct(found.xyxy[order])]
        order = order[: self._config.max_detections]
        spent = dict(found.timings_ms)
        spent["post"] = 1e3 * (time.perf_counter() - began) - spent["pre"] - spent["infer"]
        return Detections(
            found.xywh[order], scores[order], classes[order].astype(np.int64), self.class_names,
            spent,
        )  # fmt: skip


def _distinct(corners: NDArray[np.float64]) -> list[int]:
    """Return which boxes (n, 4), the best first, are no part of a better one, nor around it."""
    areas = (corners[:, 2:] - corners[:, :2]).prod(axis=1)
    kept: list[int] = []
    for i, box in enumerate(corners):
        low = np.maximum(corners[kept, :2], box[:2])
        both = np.maximum(np.minimum(corners[kept, 2:], box[2:]) - low, 0.0).prod(axis=1)
        if (both <= _PART * np.minimum(areas[kept], areas[i])).all():
            kept.append(i)
    return kept
