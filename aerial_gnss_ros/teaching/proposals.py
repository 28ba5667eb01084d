# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What stands out from the water in an image: boxes and their colours.

Boxes are (centre x, centre y, width, height) in px; the first pixel spans 0 to 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.anomaly import ANOMALY, AnomalyDetector
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.outline import TUNING as OUTLINE
from aerial_gnss_ros.detection.outline import distances, surroundings, water

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tuning:
    """Constants of the proposals.

    Attributes:
        score: least score of a proposal, lower than a detector's: a wrong one costs little.
        most: greatest number of proposals in an image, the strongest.
        bins: of each colour channel's histogram.
        span: range of the histograms, levels of Lab on either side of the water's colour.
        share: weight of the outermost histogram bins' neighbours, so that colours at the border
            of two bins are alike.
    """

    score: float = 0.25
    most: int = 40
    bins: int = 10
    span: float = 100.0
    share: float = 0.25


TUNING = Tuning()


@dataclass(frozen=True)
class Proposals:
    """Objects that stand out in one image.

    Attributes:
        boxes: (n, 4).
        looks: (n, k) histograms of their colours, see `looks`.
    """

    boxes: Array
    looks: Array


class Proposer:
    """Finds what stands out in images."""

    def __init__(self) -> None:
        config = DetectorConfig(
            model=ANOMALY, score_threshold=TUNING.score, max_detections=TUNING.most
        )
        self._detector = AnomalyDetector(config)

    def propose(self, image: Image) -> Proposals:
        """Return the objects of an image."""
        found = self._detector.detect(image)
        boxes = found.xywh + np.array([0.5, 0.5, 0.0, 0.0])
        return Proposals(boxes, looks(image, boxes))


def looks(image: Image, boxes: Array) -> Array:
    """Return the colours (n, k) inside boxes relative to the water around each, as histograms."""
    rows = [_look(*surroundings(image, box)) for box in boxes]
    return np.array(rows).reshape(len(boxes), 3 * TUNING.bins)


def likeness(one: Array, others: Array) -> Array:
    """Return how alike a look (k,) is to others (n, k), 0 to 1: Bhattacharyya's coefficient."""
    return np.asarray(np.sqrt(one * others).sum(axis=1))


def clutter(image: Image, box: Array) -> float:
    """Return the share of the pixels round a box that are as unlike the water as what is in it."""
    patch, inner, _ = surroundings(image, box)
    apart = distances(patch, inner)
    left, top, right, bottom = inner
    own = float(np.percentile(apart[top:bottom, left:right], OUTLINE.peak))
    ring = np.ones(apart.shape, dtype=np.bool_)
    pad = 2  # compression smears an object's colours
    ring[max(top - pad, 0) : bottom + pad, max(left - pad, 0) : right + pad] = False
    if not ring.any():
        return 0.0
    return float((apart[ring] > max(OUTLINE.distance, OUTLINE.edge**2 * own)).mean())


def strength(image: Image, box: Array) -> float:
    """Return how far the colours in a box are from the water's: a high squared distance of them."""
    patch, inner, _ = surroundings(image, box)
    left, top, right, bottom = inner
    return float(np.percentile(distances(patch, inner)[top:bottom, left:right], OUTLINE.peak))


def _look(patch: NDArray[np.float32], inner: tuple[int, int, int, int], _origin: Array) -> Array:
    middle, _ = water(patch, inner)
    left, top, right, bottom = inner
    apart = distances(patch, inner)[top:bottom, left:right].ravel()
    colours = patch[top:bottom, left:right].reshape(-1, 3) - middle
    weights = np.minimum(apart / OUTLINE.distance, 1.0) + 1e-6
    bins = TUNING.bins
    place = np.clip((colours / TUNING.span + 0.5) * bins, 0.0, bins - 1e-6)
    rows = []
    kernel = np.array([TUNING.share, 1.0 - 2.0 * TUNING.share, TUNING.share])
    for channel in place.T:
        counts = np.bincount(channel.astype(int), weights, bins)
        smooth = np.convolve(counts, kernel, mode="same")
        rows.append(smooth / (3.0 * smooth.sum()))
    return np.concatenate(rows)
