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

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.anomaly import ANOMALY, AnomalyDetector
from aerial_gnss_ros.detection.base import Detections, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.outline import outlined
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.detection.yolo import iou

TERMS = Terms(from_score=0.1, to_score=1.0, most=64)
"""Of the networks that `teach` trains: faint things too, as the network is what decides."""
_TO_MIDDLES = np.array([0.5, 0.5, 0.0, 0.0])  # from coordinates of pixel edges to pixel centres


class Proposer:
    """Finds what may be a robot.

    Args:
        terms: least score and greatest number of the boxes.
        iou_threshold: of two boxes that overlap more than this, the better one is kept.
    """

    def __init__(self, terms: Terms, iou_threshold: float = DetectorConfig.iou_threshold) -> None:
        self._overlap = iou_threshold
        self._anomaly = AnomalyDetector(
            DetectorConfig(
                model=ANOMALY, score_threshold=terms.from_score, max_detections=terms.most
            )
        )

    def detect(self, image: Image) -> Detections:
        """Return the boxes, each around the outline of its object, best score first."""
        found = self._anomaly.detect(image)
        boxes = found.xywh.copy()
        for box in boxes:
            outline = outlined(image, box + _TO_MIDDLES)
            if outline is not None:
                box[:] = outline - _TO_MIDDLES
        drawn = replace(found, xywh=boxes)
        shared = iou(drawn.xyxy, drawn.xyxy)
        kept: list[int] = []
        for i in range(len(drawn)):  # coarse boxes of one object may have one outline
            if (shared[i, kept] <= self._overlap).all():
                kept.append(i)
        return replace(
            drawn, xywh=boxes[kept], scores=found.scores[kept], class_ids=found.class_ids[kept]
        )


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
        order = order[: self._config.max_detections]
        spent = dict(found.timings_ms)
        spent["post"] = 1e3 * (time.perf_counter() - began) - spent["pre"] - spent["infer"]
        return Detections(
            found.xywh[order], scores[order], classes[order].astype(np.int64), self.class_names,
            spent,
        )  # fmt: skip
