# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The outline of one object on water: which pixels round a rough box are unlike the water there.

Boxes are (centre x, centre y, width, height) in px; the first pixel spans 0 to 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image

Array = NDArray[np.float64]
Inner = tuple[int, int, int, int]
"""Left, top, right, bottom of a box in a patch."""


@dataclass(frozen=True)
class Tuning:
    """Constants of the outline.

    Attributes:
        margin: the outline of an object is searched in its box, enlarged by this factor.
        distance: squared Mahalanobis distance from the water at which a pixel belongs to an object.
        peak: percentile of the squared distances in a box that counts as the object's own.
        edge: share of that distance (not squared) at the outline: compression smears colours.
        least_px: sides of the smallest outline.
    """

    margin: float = 2.2
    distance: float = 16.0
    peak: float = 90.0
    edge: float = 0.25
    least_px: float = 3.0


TUNING = Tuning()


def outlined(image: Image, box: Array) -> Array | None:
    """Return the box (4,) of the object that a rough box touches; None if nothing stands out."""
    around, inner, origin = surroundings(image, box)
    if min(around.shape[:2]) < TUNING.least_px:
        return None
    left, top, right, bottom = inner
    mask = unlike_water(around, inner)
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


def unlike_water(around: NDArray[np.float32], inner: Inner) -> NDArray[np.uint8]:
    """Return which pixels (h, w) of a patch belong to what stands out in its box: 1, else 0."""
    apart = distances(around, inner)
    left, top, right, bottom = inner
    peak = float(np.percentile(apart[top:bottom, left:right], TUNING.peak))
    clear = (apart > max(TUNING.distance, TUNING.edge**2 * peak)).astype(np.uint8)
    closed = cv2.morphologyEx(clear, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    return np.asarray(closed, dtype=np.uint8)


def surroundings(
    image: Image, box: Array
) -> tuple[NDArray[np.float32], Inner, NDArray[np.float64]]:
    """Return the colours round a box in Lab, the box in the patch, and the patch's corner."""
    height, width = image.shape[:2]
    half = 0.5 * TUNING.margin * np.maximum(box[2:], 8.0)
    low = np.clip(np.floor(box[:2] - half), 0, (width - 1, height - 1)).astype(int)
    high = np.clip(np.ceil(box[:2] + half), low + 1, (width, height)).astype(int)
    colours = cv2.cvtColor(image[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2LAB)
    size = high - low
    begin = np.clip(np.round(box[:2] - box[2:] / 2 - low), 0, size - 1).astype(int)
    end = np.clip(np.round(box[:2] + box[2:] / 2 - low), begin + 1, size).astype(int)
    inner = (int(begin[0]), int(begin[1]), int(end[0]), int(end[1]))
    return colours.astype(np.float32), inner, low.astype(np.float64)


def water(around: NDArray[np.float32], inner: Inner) -> tuple[Array, Array]:
    """Return the water's median colour (3,) and covariance (3, 3) from the pixels off the box."""
    ring = np.ones(around.shape[:2], dtype=np.bool_)
    ring[inner[1] : inner[3], inner[0] : inner[2]] = False
    colours = around[ring].astype(np.float64)
    if len(colours) < 16:
        colours = around.reshape(-1, 3).astype(np.float64)
    middle = np.median(colours, axis=0)
    # The half that is nearest to the median: another object beside it does not count.
    off = np.abs(colours - middle).sum(axis=1)
    near = colours[off <= np.median(off)]
    spread = 4.0 * np.cov(near.T) if len(near) > 3 else np.zeros((3, 3))
    return middle, np.asarray(spread) + np.eye(3)


def distances(around: NDArray[np.float32], inner: Inner) -> Array:
    """Return squared Mahalanobis distances (h, w) of a patch from the water in it."""
    middle, spread = water(around, inner)
    smooth = cv2.medianBlur(around, 3).astype(np.float64) - middle
    return np.asarray(np.einsum("ijk,kl,ijl->ij", smooth, np.linalg.inv(spread), smooth))
