# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chooses training samples for the small detector: random windows of labelled images."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.training.labelled import LabelledImage

_WITH_ROBOT = 0.6  # share of the crops that are placed around a robot, where there are robots
_SCALES = (0.6, 1.6)  # factor on an image's size
_LEAST_SHARE = 0.4  # of a robot within the crop: less is neither a robot nor none
_LEAST_PX = 8.0  # long side of a robot in the crop: a smaller one is neither, too


@dataclass
class Pool:
    """Labelled images in memory, each with the weight with which it is drawn.

    Attributes:
        images: (height, width, 3) blue, green, red.
        corners: of each image, (n, 4) left, top, right, bottom of its robots; edges of pixels.
        classes: of each image, (n,) index of the class of each robot; -1: it does not count.
        weights: of each image.
    """

    images: list[Image] = field(default_factory=list)
    corners: list[NDArray[np.float64]] = field(default_factory=list)
    classes: list[NDArray[np.int64]] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)

    def add(self, images: Iterable[LabelledImage], weight: float = 1.0) -> None:
        """Add images; `weight` is relative to the pixels of each."""
        for labelled in images:
            image, truth = labelled.read(), labelled.truth
            self.images.append(image)
            self.corners.append(truth.corners + 0.5)
            self.classes.append(np.where(truth.counted, truth.class_ids, -1))
            self.weights.append(weight * image.shape[0] * image.shape[1])

    def extend(self, other: Pool) -> None:
        """Add another pool's images."""
        self.images += other.images
        self.corners += other.corners
        self.classes += other.classes
        self.weights += other.weights

    def drawn(self, rng: np.random.Generator, count: int) -> NDArray[np.int64]:
        """Return indices (count,) of images, drawn by their weights.

        Raises:
            InputError: the pool is empty.
        """
        if not self.images:
            raise InputError("there are no images to train with.")
        chances = np.asarray(self.weights) / np.sum(self.weights)
        return rng.choice(len(self.images), count, p=chances)


@dataclass(frozen=True)
class Crop:
    """A square window of an image, how it is turned, and the robots in it.

    Attributes:
        left, top: of the window in the image, px.
        reach: its side in the image, px.
        turns: by quarters, counter-clockwise as np.rot90.
        mirrored: left to right, after turning.
        corners: (n, 4) left, top, right, bottom of its robots, clipped; px of the crop.
        classes: (n,) of these.
        partly: (m, 4) of what is neither a robot nor none: too little of it is seen.
    """

    left: int
    top: int
    reach: int
    turns: int
    mirrored: bool
    corners: NDArray[np.float64]
    classes: NDArray[np.int64]
    partly: NDArray[np.float64]


def random_crop(
    rng: np.random.Generator,
    size: tuple[int, int],
    corners: NDArray[np.float64],
    classes: NDArray[np.int64],
    side: int,
) -> Crop:
    """Return a random crop of an image: scaled, turned by quarters, mirrored.

    Args:
        rng: all randomness.
        size: width and height of the image, px.
        corners: (n, 4) of its robots, as in `Pool`.
        classes: (n,) of these.
        side: of the crop, px.
    """
    scale = float(np.exp(rng.uniform(*np.log(_SCALES))))
    least = min(size)
    scale = max(scale, side / float(least))
    span = side / scale  # of the crop in the image, px
    if len(corners) and rng.random() < _WITH_ROBOT:
        robot = corners[int(rng.integers(len(corners)))]
        middle = (robot[:2] + robot[2:]) / 2 - rng.uniform(0.1, 0.9, 2) * span
    else:
        middle = rng.uniform(0.0, 1.0, 2) * (np.asarray(size) - span)
    reach = int(min(np.ceil(span), least))
    left_top = np.clip(np.round(middle), 0.0, np.asarray(size) - reach)
    moved = (corners - np.tile(left_top, 2)) * (side / reach)
    turns, mirrored = int(rng.integers(4)), bool(rng.integers(2))
    for _ in range(turns):
        left, top, right, bottom = moved.T
        moved = np.stack([top, side - right, bottom, side - left], axis=1)
    if mirrored:
        moved = np.stack([side - moved[:, 2], moved[:, 1], side - moved[:, 0], moved[:, 3]], axis=1)
    clipped = np.clip(moved, 0.0, side)
    seen = np.prod(np.maximum(clipped[:, 2:] - clipped[:, :2], 0.0), axis=1)
    share = seen / np.maximum(np.prod(moved[:, 2:] - moved[:, :2], axis=1), 1e-9)
    long_px = (moved[:, 2:] - moved[:, :2]).max(axis=1, initial=0.0)
    whole = (share >= _LEAST_SHARE) & (classes >= 0) & (long_px >= _LEAST_PX)
    partly = (share > 0.0) & ~whole
    x, y = left_top.astype(int)
    return Crop(
        int(x), int(y), reach, turns, mirrored, clipped[whole], classes[whole], clipped[partly]
    )  # fmt: skip
