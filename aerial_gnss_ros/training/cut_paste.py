# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cuts labelled robots out of images and pastes them elsewhere on water.

Dwibedi, Misra and Hebert, "Cut, paste and learn", ICCV 2017.

Their colours are kept relative to the water around them, so that a robot seen through water, or in
other light, fits its new place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.outline import surroundings, unlike_water
from aerial_gnss_ros.training.labelled import Truth

F32 = NDArray[np.float32]
_SOFT_PX = 1.0
_SCALES = 0.25  # sigma of the logarithm of its size
_LIGHTS = 0.1  # sigma of the logarithm of its contrast
_APART_PX = 20.0
_LEAST_PX = 9  # pixels of a robot that is no speck
_TO_EDGES = np.array([0.5, 0.5])


@dataclass(frozen=True)
class Cutout:
    """A robot without its water.

    Attributes:
        colours: (h, w, 3) blue, green, red above the water's, levels.
        share: (h, w) of each pixel that the robot fills, 0 to 1.
        class_id: of the robot.
    """

    colours: F32
    share: F32
    class_id: int


def cut_out(image: Image, truth: Truth) -> list[Cutout]:
    """Return the labelled robots of an image that stand out from the water."""
    found = []
    height, width = image.shape[:2]
    for (left, top, right, bottom), kind in zip(truth.corners, truth.class_ids, strict=True):
        middle = np.array([left + right, top + bottom]) / 2.0 + _TO_EDGES
        if left < 0.0 or top < 0.0 or right > width - 1 or bottom > height - 1:
            continue  # a part of a robot must not float anywhere
        box = np.array([*middle, right - left, bottom - top])
        around, inner, corner = surroundings(image, box)
        x, y = corner.astype(int)
        here = image[y : y + around.shape[0], x : x + around.shape[1]].astype(np.float32)
        inside = np.zeros(around.shape[:2], np.float32)
        inside[max(inner[1] - 1, 0) : inner[3] + 1, max(inner[0] - 1, 0) : inner[2] + 1] = 1.0
        own = unlike_water(around, inner) * inside
        if own.sum() < _LEAST_PX or own.all():
            continue
        water = np.median(here[own == 0], axis=0)
        share = np.asarray(cv2.GaussianBlur(own, (0, 0), _SOFT_PX), np.float32)
        found.append(Cutout(here - water, share, int(kind)))
    return found


def pasted(
    rng: np.random.Generator, image: Image, truth: Truth, cutouts: Sequence[Cutout], count: int
) -> tuple[Image, Truth]:
    """Return an image with robots pasted into it, turned and scaled at random, and its labels.

    Args:
        rng: all randomness.
        image: (height, width, 3) blue, green, red.
        truth: what is in it; no robot is pasted near it.
        cutouts: to choose from.
        count: of robots; those for which there is no place are left out.
    """
    made = image.copy()
    corners, kinds = list(truth.corners), list(truth.class_ids)
    for number in rng.integers(len(cutouts), size=count):
        one = _turned(rng, cutouts[number])
        height, width = np.subtract(image.shape[:2], one.share.shape)
        if min(height, width) < 1:
            continue
        x, y = int(rng.integers(width)), int(rng.integers(height))
        rows, columns = np.nonzero(one.share > 0.5)
        if len(rows) < _LEAST_PX:
            continue
        low = np.array([x + columns.min(), y + rows.min()]) - _TO_EDGES
        high = np.array([x + columns.max(), y + rows.max()]) + _TO_EDGES
        if any(_near(low, high, other) for other in corners):
            continue
        _put(made[y : y + one.share.shape[0], x : x + one.share.shape[1]], one)
        corners.append(np.concatenate([low, high]))
        kinds.append(one.class_id)
    boxes = np.array(corners, dtype=np.float64).reshape(-1, 4)
    long_px = (boxes[:, 2:] - boxes[:, :2]).max(axis=1, initial=0.0)
    count = len(boxes)
    whole = Truth(
        boxes, np.ones(count, np.bool_), long_px, np.full(count, np.nan),
        np.array(kinds, dtype=np.int64),
    )  # fmt: skip
    return made, whole


def _put(here: Image, one: Cutout) -> None:
    """Draw a robot over the water of a part of an image."""
    before = here.astype(np.float32)
    water = np.median(before.reshape(-1, 3), axis=0)
    share = one.share[..., None]
    after = before + share * (water + one.colours - before)
    here[:] = np.clip(np.round(after), 0, 255).astype(np.uint8)


def _turned(rng: np.random.Generator, one: Cutout) -> Cutout:
    """Return a robot in another direction, mirrored or not, of another size and contrast."""
    scale = float(np.exp(rng.normal(0.0, _SCALES)))
    size = np.array(one.share.shape[::-1], dtype=np.float64)
    side = int(np.ceil(np.hypot(*size) * scale)) + 2
    angle = float(rng.uniform(0.0, 360.0))
    move = np.array(cv2.getRotationMatrix2D((size / 2.0).tolist(), angle, scale), np.float64)
    move[:, 2] += side / 2.0 - size / 2.0
    if rng.random() < 0.5:
        move[0] = -move[0] + (0.0, 0.0, side - 1.0)
    colours = cv2.warpAffine(one.colours, move, (side, side), flags=cv2.INTER_LINEAR)
    share = cv2.warpAffine(one.share, move, (side, side), flags=cv2.INTER_LINEAR)
    light = np.float32(np.exp(rng.normal(0.0, _LIGHTS)))
    return Cutout(np.asarray(colours) * light, np.asarray(share), one.class_id)


def _near(low: NDArray[np.float64], high: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool((low - _APART_PX < other[2:]).all() and (high + _APART_PX > other[:2]).all())
