# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rectangles of an image that a network processes one by one, and their choice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.letterbox import STRIDE

SIDES = (128, 160, 192, 256, 320, 448, 640, 960, 1280)
"""Sides of windows around boxes, px. Few sizes, because a runtime prepares for each."""
_EACH = 15_000  # a window's fixed cost, as a number of pixels


@dataclass(frozen=True)
class Window:
    """A rectangle of whole pixels within an image."""

    left: int
    top: int
    width: int
    height: int

    @property
    def cost(self) -> int:
        """The cost of processing it, in pixels."""
        return self.width * self.height + _EACH

    @property
    def corners(self) -> NDArray[np.float64]:
        """(4,) left, top, right, bottom, px, as in boxes: the first pixel's centre is 0."""
        end = (self.left + self.width, self.top + self.height)
        return np.array([self.left, self.top, *end], dtype=np.float64) - 0.5

    def of(self, image: Image) -> Image:
        """Return this part of an image, a view."""
        return image[self.top : self.top + self.height, self.left : self.left + self.width]

    def inner_edges(self, size: tuple[int, int]) -> NDArray[np.bool_]:
        """Return (4,) for left, top, right, bottom whether the image continues beyond it."""
        right, bottom = self.left + self.width, self.top + self.height
        return np.array([self.left > 0, self.top > 0, right < size[0], bottom < size[1]])


def grid(size: tuple[int, int], tile: tuple[int, int], overlap: int) -> list[Window]:
    """Return windows of one size that cover an image, row by row, evenly spread.

    Args:
        size: width and height of the image, px.
        tile: width and height of a window, px; clipped to the image.
        overlap: neighbours share at least this much, px.
    """
    width, height = (min(side, whole) for side, whole in zip(tile, size, strict=True))
    return [
        Window(left, top, width, height)
        for top in _starts(size[1], height, overlap)
        for left in _starts(size[0], width, overlap)
    ]


def _starts(whole: int, part: int, overlap: int) -> list[int]:
    step = max(1, part - overlap)
    count = 1 + max(0, -(-(whole - part) // step))
    return [round(i * (whole - part) / max(1, count - 1)) for i in range(count)]


def split(size: tuple[int, int], most: int, overlap: int) -> list[Window]:
    """Return at most `most` windows that cover an image, as small and as square as they can be.

    Args:
        size: width and height of the image, px.
        most: greatest number.
        overlap: neighbours share at least this much, px.
    """
    best = [Window(0, 0, *size)]
    for columns in range(1, most + 1):
        for rows in range(1, most // columns + 1):
            tile = (_side(size[0], columns, overlap), _side(size[1], rows, overlap))
            found = grid(size, tile, overlap)
            if len(found) <= most and _unwieldy(found[0]) < _unwieldy(best[0]):
                best = found
    return best


def _side(whole: int, parts: int, overlap: int) -> int:
    """Return a window side, in whole strides, such that `parts` windows cover a side."""
    side = -(-(whole + (parts - 1) * overlap) // parts)
    return STRIDE * -(-side // STRIDE)


def _unwieldy(window: Window) -> tuple[int, int]:
    return window.cost, max(window.width, window.height)


def around(corners: NDArray[np.float64], size: tuple[int, int]) -> list[Window]:
    """Return windows that cover all boxes, one for several if that costs less.

    Args:
        corners: (n, 4) boxes with their margins, px.
        size: width and height of the image, px.
    """
    groups: list[NDArray[np.float64]] = []
    for box in corners[np.argsort(corners[:, 0], kind="stable")]:
        alone = _window(box, size).cost
        joined = [np.hstack([np.minimum(g, box)[:2], np.maximum(g, box)[2:]]) for g in groups]
        extra = [
            _window(after, size).cost - _window(before, size).cost
            for before, after in zip(groups, joined, strict=True)
        ]
        cheapest = int(np.argmin(extra)) if extra else -1
        if extra and extra[cheapest] < alone:
            groups[cheapest] = joined[cheapest]
        else:
            groups.append(box)
    return [_window(group, size) for group in groups]


def _window(box: NDArray[np.float64], size: tuple[int, int]) -> Window:
    """Return the smallest of the standard squares that covers a box, moved into the image."""
    low = np.clip(np.floor(box[:2] + 0.5), 0, np.array(size) - 1)
    high = np.clip(np.ceil(box[2:] + 0.5), 1, size)
    needed = int((high - low).max())
    side = next((s for s in SIDES if s >= needed), max(size))
    sides = [min(side, whole) for whole in size]
    middle = (low + high) / 2
    starts = [
        int(np.clip(round(m - s / 2), 0, whole - s))
        for m, s, whole in zip(middle, sides, size, strict=True)
    ]
    return Window(*starts, *sides)
