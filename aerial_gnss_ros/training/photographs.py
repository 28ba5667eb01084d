# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Photographs of water, what is labelled in them, and random parts of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.training.labelled import ENDINGS
from aerial_gnss_ros.training.picture_labels import PictureLabels

_PATCH_PX = 25  # size of the surroundings by which water is told from land


@dataclass(frozen=True)
class Photograph:
    """A part of a photograph.

    Attributes:
        image: (side, side, 3) blue, green, red.
        objects: (n, 4) left, top, right, bottom of what is labelled in it, px.
        water: (side, side) whether robots may be put there.
    """

    image: Image
    objects: NDArray[np.float64]
    water: NDArray[np.bool_]


def water_of(image: Image, share: float) -> NDArray[np.bool_]:
    """Return where an image (height, width, 3) has least texture: its calmest `share`."""
    if share >= 1.0:
        return np.ones(image.shape[:2], dtype=np.bool_)
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32)
    patch = (_PATCH_PX, _PATCH_PX)
    mean, square = cv2.blur(grey, patch), cv2.blur(grey * grey, patch)
    # The greatest texture around, so that the middle of a roof is no water either.
    texture = cv2.dilate(np.maximum(square - mean * mean, 0.0), np.ones(patch, np.uint8))
    return np.asarray(texture <= np.quantile(texture, share), dtype=np.bool_)


def random_part(
    rng: np.random.Generator,
    image: Image,
    objects: NDArray[np.float64],
    side: int,
    scales: tuple[float, float],
    calm: float,
) -> Photograph:
    """Return a random part of a photograph: scaled, cut, turned by quarters and mirrored.

    Args:
        rng: all randomness.
        image: (height, width, 3).
        objects: (n, 4) left, top, right, bottom of what is labelled in it, px.
        side: of the part, px.
        scales: least and greatest factor on the photograph's size.
        calm: share of the photograph that is taken for water (`water_of`).
    """
    least = side / min(image.shape[:2])
    low, high = np.log(np.maximum(scales, least))
    scale = float(np.exp(rng.uniform(low, high)))
    height, width = (max(side, round(length * scale)) for length in image.shape[:2])
    way = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    sized = np.asarray(cv2.resize(image, (width, height), interpolation=way), np.uint8)
    x, y = (int(rng.integers(length - side + 1)) for length in (width, height))
    here = slice(y, y + side), slice(x, x + side)
    # The share is one of the whole photograph: a part of it may be all land.
    cut, water = sized[here], water_of(sized, calm)[here]
    boxes = objects * scale - np.tile([x, y], 2)
    turns, mirrored = int(rng.integers(4)), bool(rng.integers(2))
    for _ in range(turns):
        cut, water, boxes = np.rot90(cut), np.rot90(water), _turned(boxes, side)
    if mirrored:
        cut, water = cut[:, ::-1], water[:, ::-1]
        boxes = boxes[:, [2, 1, 0, 3]] * (-1, 1, -1, 1) + np.array([1, 0, 1, 0]) * (side - 1)
    return Photograph(np.ascontiguousarray(cut), boxes, water)


def _turned(boxes: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """Return boxes (n, 4) in a square turned by a quarter, counter-clockwise as np.rot90."""
    left, top, right, bottom = boxes.T
    return np.stack([top, side - 1 - right, bottom, side - 1 - left], axis=1)


def photographs_of(
    folder: Path, labels: Path | None, scenes: Sequence[str] = ()
) -> list[tuple[Path, NDArray[np.float64]]]:
    """Return a folder's photographs with what is labelled in them.

    Args:
        folder: of the images.
        labels: their table; None: nothing is known about them.
        scenes: if given, only files whose names begin with one of these.

    Raises:
        InputError: the folder has none, or the table cannot be read.
    """
    paths = [path for path in sorted(folder.glob("*")) if path.suffix.lower() in ENDINGS]
    if scenes:
        paths = [path for path in paths if path.name.startswith(tuple(scenes))]
    if not paths:
        raise InputError(f"{folder} has no images; give a folder of photographs (.jpg, .png).")
    table = None if labels is None else PictureLabels(labels, ())
    found = []
    for path in paths:
        known = None if table is None else table.of(path.name, (0, 0))
        found.append((path, np.zeros((0, 4)) if known is None else known.corners))
    return found
