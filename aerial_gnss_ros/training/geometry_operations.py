# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Augmentations that move pixels: each is a matrix and the size of the canvas afterwards.

Points are in pixels with the image's first pixel spanning 0 to 1, as in YOLO's labels. A matrix
maps a point (x, y, 1) of the canvas before to the canvas after.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Size = tuple[int, int]  # width, height
Movement = tuple[Array, Size]
GeometryOperation = Callable[[np.random.Generator, Size, Array], Movement]
"""(random numbers, size of the canvas, centres (n, 2) of the boxes) -> matrix (3, 3), new size."""

TILT_DEG = 10.0
"""Greatest rotation besides quarter turns, deg: a box says little about its robot's orientation
(see carrying.py)."""
SHEAR_DEG = 5.0
SCALE = 1.25
TRANSLATE = 0.1  # of the canvas
LEAST_CROP = 0.6  # of each side
MOST_PAD = 0.15  # of each side


def rotation(rng: np.random.Generator, size: Size, _: Array) -> Movement:
    """Turn by quarter turns, which keep boxes exact, and up to TILT_DEG either way."""
    turns, tilt = int(rng.integers(4)), np.radians(rng.uniform(-TILT_DEG, TILT_DEG))
    width, height = size if turns % 2 == 0 else size[::-1]
    cosine, sine = [(1, 0), (0, 1), (-1, 0), (0, -1)][turns]
    quarter = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]], dtype=np.float64)
    turned = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    return _about(turned, (width, height), (width, height)) @ _recentred(
        quarter, size, (width, height)
    ), (width, height)


def flip_horizontal(_: np.random.Generator, size: Size, __: Array) -> Movement:
    """Swap left and right."""
    return np.array([[-1.0, 0.0, size[0]], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), size


def flip_vertical(_: np.random.Generator, size: Size, __: Array) -> Movement:
    """Swap top and bottom: a camera that looks down has no preferred orientation."""
    return np.array([[1.0, 0.0, 0.0], [0.0, -1.0, size[1]], [0.0, 0.0, 1.0]]), size


def crop(rng: np.random.Generator, size: Size, centres: Array) -> Movement:
    """Crop to a window of LEAST_CROP to 1 of each side."""
    shares = rng.uniform(LEAST_CROP, 1.0, 2)
    window = max(1, round(size[0] * shares[0])), max(1, round(size[1] * shares[1]))
    return crop_to(rng, size, centres, window)


def crop_to(rng: np.random.Generator, size: Size, centres: Array, window: Size) -> Movement:
    """Crop to a window of the given size, or the part of it on the canvas.

    Its position is drawn among those that keep every box's centre; if there are none, among all.
    """
    kept = min(window[0], size[0]), min(window[1], size[1])
    corner = []
    for axis in (0, 1):
        lowest, highest = 0, size[axis] - kept[axis]
        if len(centres):
            least = int(np.floor(centres[:, axis].max())) - kept[axis] + 1
            most = int(np.floor(centres[:, axis].min()))
            if max(lowest, least) <= min(highest, most):
                lowest, highest = max(lowest, least), min(highest, most)
        corner.append(int(rng.integers(lowest, highest + 1)))
    return _shift(-corner[0], -corner[1]), kept


def pad(rng: np.random.Generator, size: Size, _: Array) -> Movement:
    """Add up to MOST_PAD of its length at each side."""
    shares = rng.uniform(0.0, MOST_PAD, 4)
    left, right = round(size[0] * shares[0]), round(size[0] * shares[1])
    top, bottom = round(size[1] * shares[2]), round(size[1] * shares[3])
    return _shift(left, top), (size[0] + left + right, size[1] + top + bottom)


def affine(rng: np.random.Generator, size: Size, _: Array) -> Movement:
    """Scale each axis by 1/SCALE to SCALE, shear up to SHEAR_DEG, shift up to TRANSLATE."""
    common, aspect = rng.uniform(-1.0, 1.0, 2)
    scale_x, scale_y = SCALE ** (common + 0.3 * aspect), SCALE ** (common - 0.3 * aspect)
    shear_x, shear_y = np.tan(np.radians(rng.uniform(-SHEAR_DEG, SHEAR_DEG, 2)))
    shift = rng.uniform(-TRANSLATE, TRANSLATE, 2) * size
    linear = np.array([[scale_x, shear_x], [shear_y, scale_y]])
    return _shift(*shift) @ _about(linear, size, size), size


def _shift(x: float, y: float) -> Array:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def _about(linear: Array, before: Size, after: Size) -> Array:
    """Return the (2, 2) map about the middle of the canvas."""
    matrix = np.eye(3)
    matrix[:2, :2] = linear
    return _recentred(matrix, before, after)


def _recentred(matrix: Array, before: Size, after: Size) -> Array:
    return _shift(after[0] / 2, after[1] / 2) @ matrix @ _shift(-before[0] / 2, -before[1] / 2)
