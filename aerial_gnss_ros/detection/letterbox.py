# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fits an image of any size into the network's input, and maps boxes back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image

STRIDE = 32
_GREY = 114  # the padding of YOLO networks in training


@dataclass(frozen=True)
class Letterbox:
    """Shrinks (never enlarges) with the same factor both ways, then pads with grey on all sides.

    Coordinates are of pixel edges: 0 is the left of the first pixel, `width` the right of the last
    one, so that scaling is a pure factor.

    Attributes:
        source: width and height of the image, px.
        network: width and height of the network's input, px.
        inner: width and height of the shrunk image within it, px.
        corner: left and top of the shrunk image within it, px.
    """

    source: tuple[int, int]
    network: tuple[int, int]
    inner: tuple[int, int]
    corner: tuple[int, int]

    @classmethod
    def fixed(cls, source: tuple[int, int], network: tuple[int, int]) -> Letterbox:
        """Return the fit into a network whose input size is fixed; sizes are width, height."""
        factor = min(1.0, network[0] / source[0], network[1] / source[1])
        inner = (max(1, round(source[0] * factor)), max(1, round(source[1] * factor)))
        corner = ((network[0] - inner[0]) // 2, (network[1] - inner[1]) // 2)
        return cls(source, network, inner, corner)

    @classmethod
    def flexible(cls, source: tuple[int, int], longest: int, stride: int = STRIDE) -> Letterbox:
        """Return the fit into the smallest rectangle of whole strides.

        Args:
            source: width and height, px.
            longest: longest side of the shrunk image, px.
            stride: divisor of the input's sides.
        """
        factor = min(1.0, longest / max(source))
        sides = [stride * -(-max(1, round(side * factor)) // stride) for side in source]
        inner = (max(1, round(source[0] * factor)), max(1, round(source[1] * factor)))
        corner = ((sides[0] - inner[0]) // 2, (sides[1] - inner[1]) // 2)
        return cls(source, (sides[0], sides[1]), inner, corner)

    def apply(self, image: Image) -> Image:
        """Return the padded image (network height, width, 3); `image` itself if it fits."""
        return Canvas().fill(self, image)

    def to_source(self, xyxy: NDArray[Any]) -> NDArray[np.float64]:
        """Return corners (n, 4) in source pixels from corners in network pixels."""
        factor = np.array(self.source, dtype=np.float64) / np.array(self.inner, dtype=np.float64)
        corners = np.asarray(xyxy, dtype=np.float64) - np.array([*self.corner, *self.corner])
        moved: NDArray[np.float64] = corners * np.array([*factor, *factor])
        return moved


class Canvas:
    """A reused buffer of the network's input: only the image's own pixels are copied."""

    def __init__(self) -> None:
        self._box: Letterbox | None = None
        self._pixels: Image = np.zeros((0, 0, 3), np.uint8)

    def fill(self, box: Letterbox, image: Image) -> Image:
        """Return `image` fitted in; it is overwritten by the next call, or is `image` itself."""
        width, height = box.inner
        if box.inner == box.network:
            return image if box.inner == box.source else _shrunk(image, box.inner)
        if box != self._box:
            shape = (box.network[1], box.network[0], 3)
            self._pixels, self._box = np.full(shape, _GREY, dtype=np.uint8), box
        left, top = box.corner
        inside = self._pixels[top : top + height, left : left + width]
        inside[:] = image if box.inner == box.source else _shrunk(image, box.inner)
        return self._pixels


def _shrunk(image: Image, size: tuple[int, int]) -> Image:
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
