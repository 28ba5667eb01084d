# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What stands out from the water in an image: boxes and their colours; the outline of one object.

Boxes are (centre x, centre y, width, height) in px; the first pixel spans 0 to 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.anomaly import ANOMALY, AnomalyDetector
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.config import DetectorConfig

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
        margin: the outline of an object is searched in its box, enlarged by this factor.
        distance: squared Mahalanobis distance from the water at which a pixel belongs to an object.
        peak: percentile of the squared distances in a box that counts as the object's own.
        edge: share of that distance (not squared) at the outline: compression smears colours.
        least_px: sides of the smallest outline.
    """

    score: float = 0.25
    most: int = 40
    bins: int = 10
    span: float = 100.0
    share: float = 0.25
    margin: float = 2.2
    distance: float = 16.0
    peak: float = 90.0
    edge: float = 0.25
    least_px: float = 3.0


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
    rows = [_look(*_patch(image, box)) for box in boxes]
    return np.array(rows).reshape(len(boxes), 3 * TUNING.bins)


def likeness(one: Array, others: Array) -> Array:
    """Return how alike a look (k,) is to others (n, k), 0 to 1: Bhattacharyya's coefficient."""
    return np.asarray(np.sqrt(one * others).sum(axis=1))


def outlined(image: Image, box: Array) -> Array | None:
    """Return the box (4,) of the object that a rough box touches; None if nothing stands out."""
    patch, inner, origin = _patch(image, box)
    if min(patch.shape[:2]) < TUNING.least_px:
        return None
    apart = _distances(patch, inner)
    left, top, right, bottom = inner
    peak = float(np.percentile(apart[top:bottom, left:right], TUNING.peak))
    clear = (apart > max(TUNING.distance, TUNING.edge**2 * peak)).astype(np.uint8)
    mask = cv2.morphologyEx(clear, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, parts, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    if count < 2:
        return None
    touched = np.bincount(parts[top:bottom, left:right].ravel(), minlength=count).astype(float)
    touched[0] = 0.0
    kept = touched >= max(0.2 * touched.max(), 4.0)
    # What reaches far beyond the box is a wake or a wave that touches it.
    kept &= touched >= 0.5 * stats[:, cv2.CC_STAT_AREA]
    if not kept.any():
        return None
    rows, columns = np.nonzero(kept[parts])
    low = np.array([columns.min(), rows.min()], dtype=np.float64) + origin
    size = np.array([np.ptp(columns) + 1.0, np.ptp(rows) + 1.0])
    if size.min() < TUNING.least_px:
        return None
    return np.concatenate([low + size / 2.0, size])


def clutter(image: Image, box: Array) -> float:
    """Return the share of the pixels round a box that are as unlike the water as what is in it."""
    patch, inner, _ = _patch(image, box)
    apart = _distances(patch, inner)
    left, top, right, bottom = inner
    own = float(np.percentile(apart[top:bottom, left:right], TUNING.peak))
    ring = np.ones(apart.shape, dtype=np.bool_)
    pad = 2  # compression smears an object's colours
    ring[max(top - pad, 0) : bottom + pad, max(left - pad, 0) : right + pad] = False
    if not ring.any():
        return 0.0
    return float((apart[ring] > max(TUNING.distance, TUNING.edge**2 * own)).mean())


def strength(image: Image, box: Array) -> float:
    """Return how far the colours in a box are from the water's: a high squared distance of them."""
    patch, inner, _ = _patch(image, box)
    left, top, right, bottom = inner
    return float(np.percentile(_distances(patch, inner)[top:bottom, left:right], TUNING.peak))


def _patch(
    image: Image, box: Array
) -> tuple[NDArray[np.float32], tuple[int, int, int, int], NDArray[np.float64]]:
    """Return the colours round a box in Lab, the box in the patch, and the patch's corner."""
    height, width = image.shape[:2]
    half = 0.5 * TUNING.margin * np.maximum(box[2:], 8.0)
    low = np.clip(np.floor(box[:2] - half), 0, (width - 1, height - 1)).astype(int)
    high = np.clip(np.ceil(box[:2] + half), low + 1, (width, height)).astype(int)
    patch = cv2.cvtColor(image[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2LAB)
    size = high - low
    begin = np.clip(np.round(box[:2] - box[2:] / 2 - low), 0, size - 1).astype(int)
    end = np.clip(np.round(box[:2] + box[2:] / 2 - low), begin + 1, size).astype(int)
    inner = (int(begin[0]), int(begin[1]), int(end[0]), int(end[1]))
    return patch.astype(np.float32), inner, low.astype(np.float64)


def _water(patch: NDArray[np.float32], inner: tuple[int, int, int, int]) -> tuple[Array, Array]:
    """Return the water's median colour (3,) and covariance (3, 3) from the pixels off the box."""
    ring = np.ones(patch.shape[:2], dtype=np.bool_)
    ring[inner[1] : inner[3], inner[0] : inner[2]] = False
    colours = patch[ring].astype(np.float64)
    if len(colours) < 16:
        colours = patch.reshape(-1, 3).astype(np.float64)
    middle = np.median(colours, axis=0)
    # The half that is nearest to the median: another object beside it does not count.
    off = np.abs(colours - middle).sum(axis=1)
    near = colours[off <= np.median(off)]
    spread = 4.0 * np.cov(near.T) if len(near) > 3 else np.zeros((3, 3))
    return middle, np.asarray(spread) + np.eye(3)


def _distances(patch: NDArray[np.float32], inner: tuple[int, int, int, int]) -> NDArray[np.float64]:
    middle, spread = _water(patch, inner)
    smooth = cv2.medianBlur(patch, 3).astype(np.float64) - middle
    return np.asarray(np.einsum("ijk,kl,ijl->ij", smooth, np.linalg.inv(spread), smooth))


def _look(patch: NDArray[np.float32], inner: tuple[int, int, int, int], _origin: Array) -> Array:
    middle, _ = _water(patch, inner)
    left, top, right, bottom = inner
    apart = _distances(patch, inner)[top:bottom, left:right].ravel()
    colours = patch[top:bottom, left:right].reshape(-1, 3) - middle
    weights = np.minimum(apart / TUNING.distance, 1.0) + 1e-6
    bins = TUNING.bins
    place = np.clip((colours / TUNING.span + 0.5) * bins, 0.0, bins - 1e-6)
    rows = []
    kernel = np.array([TUNING.share, 1.0 - 2.0 * TUNING.share, TUNING.share])
    for channel in place.T:
        counts = np.bincount(channel.astype(int), weights, bins)
        smooth = np.convolve(counts, kernel, mode="same")
        rows.append(smooth / (3.0 * smooth.sum()))
    return np.concatenate(rows)
