# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Crops boxes with context out of an image, at equal size, for the second look."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.second_look_terms import Terms


def views(
    image: Image, xywh: NDArray[np.float64], terms: Terms, room: float = 1.0
) -> NDArray[np.uint8]:
    """Return the near and the wide view of boxes: (n, side, side, 6), blue green red of each.

    Args:
        image: (height, width, 3) blue, green, red; beyond its edge its last pixels are repeated.
        xywh: (n, 4) centre and size, px, the middle of the first pixel being (0, 0).
        terms: sizes.
        room: factor on the views' extent and pixels.
    """
    pixels = round(terms.side * room)
    made = np.empty((len(xywh), pixels, pixels, 6), dtype=np.uint8)
    levels = [image]
    for row, (u, v, width, height) in zip(made, xywh, strict=True):
        near = max(terms.near * max(width, height), terms.least)
        row[..., :3] = _view(levels, u, v, near * room, pixels)
        row[..., 3:] = _view(levels, u, v, near * terms.wide / terms.near * room, pixels)
    return made


def turned(
    shown: NDArray[np.uint8], traits: NDArray[np.float32], way: int
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Return views (n, side, side, 6) and traits (n, 3) as if the image were turned.

    Args:
        shown: views of boxes.
        traits: of the boxes, as `second_look_terms.traits` gives them.
        way: 0 to 7: quarter turns counter-clockwise, from 4 on mirrored afterwards.
    """
    quarters = way % 4
    seen = np.rot90(shown, quarters, axes=(1, 2))
    seen = seen[:, :, ::-1] if way >= 4 else seen
    boxes = traits.copy()
    if quarters % 2:
        boxes[:, 2] *= -1.0  # upright becomes lying
    return np.ascontiguousarray(seen), boxes


def _view(levels: list[Image], u: float, v: float, side: float, pixels: int) -> Image:
    """Return the square of `side` around a position, in `pixels`; reduced without aliasing.

    Args:
        levels: the image, and its half, quarter and so on as far as needed.
        u: of the position in the image, px.
        v: of the position.
        side: px of the image.
        pixels: of the view.
    """
    wanted = max(0, math.floor(math.log2(side / pixels)))
    while len(levels) <= wanted and min(levels[-1].shape[:2]) >= 2:
        height, width = (length // 2 for length in levels[-1].shape[:2])
        even = levels[-1][: 2 * height, : 2 * width]
        levels.append(_drawn(cv2.resize(even, (width, height), interpolation=cv2.INTER_AREA)))
    level = min(wanted, len(levels) - 1)
    factor = 2.0**level
    return _square(levels[level], (u + 0.5) / factor, (v + 0.5) / factor, side / factor, pixels)


def _square(image: Image, x: float, y: float, side: float, pixels: int) -> Image:
    """Return the square around a position, reduced by less than 2."""
    left, top, scale = x - side / 2, y - side / 2, side / pixels
    if scale <= 1.0:
        to_view = np.array([
            [1 / scale, 0.0, -(left - 0.5) / scale - 0.5],
            [0.0, 1 / scale, -(top - 0.5) / scale - 0.5],
        ])  # fmt: skip
        whole = (pixels, pixels)
        edge = cv2.BORDER_REPLICATE
        return _drawn(
            cv2.warpAffine(image, to_view, whole, flags=cv2.INTER_LINEAR, borderMode=edge)
        )
    height, width = image.shape[:2]
    x0, y0 = math.floor(left), math.floor(top)
    x1, y1 = math.ceil(left + side), math.ceil(top + side)
    part = image[max(y0, 0) : min(y1, height), max(x0, 0) : min(x1, width)]
    beyond = (max(-y0, 0), max(y1 - height, 0), max(-x0, 0), max(x1 - width, 0))
    if any(beyond):
        part = _drawn(cv2.copyMakeBorder(part, *beyond, cv2.BORDER_REPLICATE))
    return _drawn(cv2.resize(part, (pixels, pixels), interpolation=cv2.INTER_AREA))


def _drawn(array: Any) -> Image:
    return np.asarray(array, dtype=np.uint8)
