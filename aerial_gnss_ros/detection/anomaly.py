# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects anything unlike the water around it, without training, as one class.

Reed and Yu, "Adaptive multiple-band CFAR detection of an optical pattern with unknown spectral
distribution", IEEE Trans. ASSP 38(10), 1990: the squared Mahalanobis distance of a pixel's colour
from those in a ring around it, at several scales. An object stands out at the scale of its size; a
glint or a crest of foam, which is smaller, only at finer ones.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.base import Detections, Image, within_image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.search_config import FULL

ANOMALY = "anomaly"
"""The model's name."""
CLASS = "object"

Plane = NDArray[Any]
"""Of float32, as OpenCV's filters are fastest."""


@dataclass(frozen=True)
class Tuning:
    """Constants of the detector.

    Attributes:
        long_side_px: an image is reduced to this before anything else: waves average out, and two
            cores process ten images a second.
        scales: further reductions; objects of about 4 to 13 px are searched in each. At full
            resolution most of what stands out is glint.
        ring_px: side of the square whose pixels are the background.
        guard_px: side of the central square that is excluded: the object itself.
        floor: least variance of colour, levels squared: rounding and compression.
        half_score: squared distance whose score is 0.5. The default threshold of 0.3 is then a
            squared distance of 51, where no pixel of Gaussian water ever is: real water has crests
            and glint.
        edge: squared distance at a box's edges, whatever the threshold of its middle is.
        overlap: boxes that share more than this of the smaller one are one object.
        most: greatest number of boxes at each scale, the strongest.
    """

    long_side_px: int = 960
    scales: tuple[int, ...] = (2, 5, 10)
    ring_px: int = 41
    guard_px: int = 13
    floor: float = 1.0
    half_score: float = 119.0
    edge: float = 20.0
    overlap: float = 0.3
    most: int = 200


TUNING = Tuning()


class AnomalyDetector:
    """Detects objects on water by colour alone.

    Args:
        config: score threshold, class name, greatest number of boxes.

    Raises:
        ConfigError: a search mode or several classes, which do not apply.
    """

    name = "anomaly (Reed-Xiaoli, any object, no network)"

    def __init__(self, config: DetectorConfig) -> None:
        if config.search.mode != FULL:
            raise ConfigError(
                f"search.mode is {config.search.mode}, but the model {ANOMALY} processes whole "
                "images; set it to full."
            )
        if len(config.class_names) > 1:
            raise ConfigError(
                f"class_names has {len(config.class_names)} names, but the model {ANOMALY} knows "
                "one class; give one name, or none."
            )
        self.class_names = config.class_names or (CLASS,)
        self._config = config

    def detect(self, image: Image) -> Detections:
        """Return boxes of anomalies, the strongest first."""
        began = time.perf_counter()
        size = (image.shape[1], image.shape[0])
        shrink = min(1.0, TUNING.long_side_px / max(size))
        colours = cv2.cvtColor(_reduced(image, shrink), cv2.COLOR_BGR2LAB).astype(np.float32)
        reduced = time.perf_counter()
        score = self._config.score_threshold
        threshold = TUNING.half_score * score / max(1.0 - score, 1e-6)
        found = [np.zeros((0, 5))]
        for scale in TUNING.scales:
            plane = _reduced(colours, 1.0 / scale)
            if min(plane.shape[:2]) >= TUNING.ring_px // 2:
                boxes = _boxes(squared_distances(cv2.blur(plane, (3, 3))), threshold)
                grown = np.array([size[0] / plane.shape[1], size[1] / plane.shape[0]])
                boxes[:, :4] *= np.tile(grown, 2)
                found.append(boxes)
        boxes = _distinct(np.concatenate(found))[: self._config.max_detections]
        done = time.perf_counter()
        return within_image(
            boxes[:, :4],
            boxes[:, 4] / (boxes[:, 4] + TUNING.half_score),
            np.zeros(len(boxes)),
            self.class_names,
            size,
            {"pre": 1e3 * (reduced - began), "infer": 1e3 * (done - reduced), "post": 0.0},
        )


def squared_distances(colours: Plane) -> Plane:
    """Return each pixel's squared Mahalanobis distance (h, w) from the ring around it.

    Args:
        colours: (h, w, 3).
    """
    a, b, c = (np.ascontiguousarray(colours[:, :, i]) for i in range(3))
    mean = [_ring_mean(one) for one in (a, b, c)]
    x, y, z = (one - of for one, of in zip((a, b, c), mean, strict=True))

    def covariance(i: int, j: int) -> Plane:
        both = (a, b, c)[i] * (a, b, c)[j]
        own: Plane = _ring_mean(both) - mean[i] * mean[j]
        return own + np.float32(TUNING.floor) if i == j else own

    s00, s11, s22 = (covariance(i, i) for i in range(3))
    s01, s02, s12 = covariance(0, 1), covariance(0, 2), covariance(1, 2)
    # The inverse of a symmetric 3 x 3 matrix by its cofactors.
    c00, c11, c22 = s11 * s22 - s12 * s12, s00 * s22 - s02 * s02, s00 * s11 - s01 * s01
    c01, c02, c12 = s02 * s12 - s01 * s22, s01 * s12 - s02 * s11, s01 * s02 - s00 * s12
    determinant = s00 * c00 + s01 * c01 + s02 * c02
    square = c00 * x * x + c11 * y * y + c22 * z * z
    square += 2.0 * (c01 * x * y + c02 * x * z + c12 * y * z)
    distances: Plane = square / np.maximum(determinant, np.float32(TUNING.floor**3))
    return distances


def _ring_mean(plane: Plane) -> Plane:
    """Return the mean over the ring around each pixel."""
    outer, inner = TUNING.ring_px, TUNING.guard_px
    whole = cv2.boxFilter(plane, -1, (outer, outer), borderType=cv2.BORDER_REFLECT)
    middle = cv2.boxFilter(plane, -1, (inner, inner), borderType=cv2.BORDER_REFLECT)
    share = inner**2 / outer**2
    mean: Plane = (whole - np.float32(share) * middle) / np.float32(1.0 - share)
    return mean


def _reduced(image: NDArray[Any], factor: float) -> NDArray[Any]:
    if factor == 1.0:
        return image
    size = [max(1, round(factor * side)) for side in image.shape[1::-1]]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def _boxes(distances: Plane, threshold: float) -> NDArray[np.float64]:
    """Return (n, 5) left, top, right, bottom and greatest squared distance, pixels of the plane."""
    if not (distances > threshold).any():
        return np.zeros((0, 5))
    mask = (distances > min(TUNING.edge, threshold)).astype(np.uint8)
    count, parts, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    peaks = np.zeros(count)
    np.maximum.at(peaks, np.asarray(parts, dtype=np.intp).ravel(), distances.ravel())
    peaks[0] = 0.0  # what is below the threshold
    kept = np.argsort(-peaks, kind="stable")[: TUNING.most]
    kept = kept[peaks[kept] > threshold]
    low = stats[kept][:, [cv2.CC_STAT_LEFT, cv2.CC_STAT_TOP]]
    size = stats[kept][:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    return np.hstack([low, low + size, peaks[kept, None]]).astype(np.float64)


def _distinct(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (m, 5) boxes, the strongest first, without those that lie on a stronger one."""
    left = boxes[np.argsort(-boxes[:, 4], kind="stable")]
    kept = []
    while len(left):
        first, left = left[0], left[1:]
        kept.append(first)
        sides = np.minimum(left[:, 2:4], first[2:4]) - np.maximum(left[:, :2], first[:2])
        shared = np.clip(sides, 0.0, None).prod(axis=1)
        areas = (left[:, 2:4] - left[:, :2]).prod(axis=1)
        own = (first[2:4] - first[:2]).prod()
        left = left[shared <= TUNING.overlap * np.minimum(areas, own)]
    return np.array(kept).reshape(-1, 5)
