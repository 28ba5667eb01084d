# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Types of image planes, and OpenCV's functions on them with those types."""

from __future__ import annotations

from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.floating[Any]]
"""Always float32 at run time (half the memory traffic); numpy's stubs widen too eagerly."""
U8 = NDArray[np.uint8]
Array = NDArray[np.float64]


def remap(source: F32, x: F32, y: F32) -> F32:
    """`source` at columns x and rows y (h, w), bilinear; outside, its edge goes on."""
    linear, go_on = cv2.INTER_LINEAR, cv2.BORDER_REPLICATE
    return cast("F32", cv2.remap(source, x, y, linear, borderMode=go_on))


def split(image: F32) -> list[F32]:
    """Planes (h, w) of an image (h, w, c)."""
    return cast("list[F32]", list(cv2.split(image)))


def merge(planes: list[F32]) -> F32:
    """The image (h, w, c) of planes (h, w)."""
    return cast("F32", cv2.merge(planes))


def transform(image: F32, matrix: NDArray[np.floating[Any]]) -> F32:
    """Matrix (3, 3) times the vector at each pixel (h, w, 3)."""
    return cast("F32", cv2.transform(image, matrix))


def resize(image: F32, size: tuple[int, int]) -> F32:
    """Bilinear interpolation to a larger `size` (width, height), whole areas over whole areas."""
    return cast("F32", cv2.resize(image, size, interpolation=cv2.INTER_LINEAR))


def shrink(image: F32, size: tuple[int, int]) -> F32:
    """Mean over the samples of each pixel of a smaller image of `size` (width, height)."""
    return cast("F32", cv2.resize(image, size, interpolation=cv2.INTER_AREA))
