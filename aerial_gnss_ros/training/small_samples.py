# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws training samples for the small detector: varied crops of labelled images, as batches."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.training.labelled import LabelledImage

F32 = NDArray[np.float32]
_STRIDE = 8
_WITH_ROBOT = 0.6  # share of the crops that are placed around a robot, where there are robots
_SCALES = (0.7, 1.45)  # factor on an image's size
_LEAST_SHARE = 0.4  # of a robot within the crop: less is neither a robot nor none
_LEAST_SIGMA, _SIGMA = 0.45, 0.11  # of a centre: places, and of a robot's side
_FADED, _EXCHANGED, _NOISY = 0.2, 0.1, 0.3  # shares of the crops


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


@dataclass(frozen=True)
class Batch:
    """What `small_network.loss` needs.

    Attributes:
        images: (n, side, side, 3) blue, green, red.
        wanted: (n, classes, h, w) map of centres.
        weight: (n, 1, h, w) 0 where nothing is known.
        truth: (n, 4, h, w) centre and size of the robot that a place belongs to, px.
    """

    images: Image
    wanted: F32
    weight: F32
    truth: F32


def draw(rng: np.random.Generator, pool: Pool, count: int, side: int, classes: int = 1) -> Batch:
    """Return a batch of varied crops.

    Args:
        rng: all randomness.
        pool: of images.
        count: crops.
        side: of a crop, px; a multiple of 32.
        classes: how many.

    Raises:
        InputError: the pool is empty.
    """
    if not pool.images:
        raise InputError("there are no images to train with.")
    chances = np.asarray(pool.weights) / np.sum(pool.weights)
    drawn = []
    for number in rng.choice(len(pool.images), count, p=chances):
        crop, corners, kinds, partly = crop_of(
            rng, pool.images[number], pool.corners[number], pool.classes[number], side
        )
        drawn.append((_coloured(rng, crop), *maps_of(corners, kinds, partly, side, classes)))
    images, wanted, weight, truth = (np.stack(parts) for parts in zip(*drawn, strict=True))
    return Batch(images, wanted, weight, truth)


def crop_of(
    rng: np.random.Generator,
    image: Image,
    corners: NDArray[np.float64],
    kinds: NDArray[np.int64],
    side: int,
) -> tuple[Image, NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Return a random crop: scaled, turned by quarters, mirrored; robots in it, and parts of some.

    Returns:
        The crop (side, side, 3), corners (n, 4) and classes (n,) of its robots, clipped, and
        corners (m, 4) of what is neither a robot nor none: too little of it is seen.
    """
    scale = float(np.exp(rng.uniform(*np.log(_SCALES))))
    size = np.array([image.shape[1], image.shape[0]], dtype=np.float64)
    scale = max(scale, side / float(size.min()) if size.min() < side else 0.0)
    span = side / scale  # of the crop in the image, px
    if len(corners) and rng.random() < _WITH_ROBOT:
        robot = corners[int(rng.integers(len(corners)))]
        middle = (robot[:2] + robot[2:]) / 2 - rng.uniform(0.1, 0.9, 2) * span
    else:
        middle = rng.uniform(0.0, 1.0, 2) * (size - span)
    left_top = np.clip(np.round(middle), 0.0, np.maximum(np.floor(size - span), 0.0))
    x, y = left_top.astype(int)
    reach = int(min(np.ceil(span), size.min()))
    cut = image[y : y + reach, x : x + reach]
    way = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    made = np.asarray(cv2.resize(cut, (side, side), interpolation=way), np.uint8)
    moved = (corners - np.tile(left_top, 2)) * (side / reach)
    for _ in range(int(rng.integers(4))):
        made = np.rot90(made)
        left, top, right, bottom = moved.T
        moved = np.stack([top, side - right, bottom, side - left], axis=1)
    if rng.integers(2):
        made = made[:, ::-1]
        moved = np.stack([side - moved[:, 2], moved[:, 1], side - moved[:, 0], moved[:, 3]], axis=1)
    clipped = np.clip(moved, 0.0, side)
    seen = np.prod(np.maximum(clipped[:, 2:] - clipped[:, :2], 0.0), axis=1)
    share = seen / np.maximum(np.prod(moved[:, 2:] - moved[:, :2], axis=1), 1e-9)
    whole = (share >= _LEAST_SHARE) & (kinds >= 0)
    partly = (share > 0.0) & ~whole
    return np.ascontiguousarray(made), clipped[whole], kinds[whole], clipped[partly]


def maps_of(
    corners: NDArray[np.float64],
    kinds: NDArray[np.int64],
    partly: NDArray[np.float64],
    side: int,
    classes: int,
) -> tuple[F32, F32, F32]:
    """Return the wanted map of centres, its weight, and the box that each place belongs to."""
    count = side // _STRIDE
    wanted = np.zeros((classes, count, count), np.float32)
    weight = np.ones((1, count, count), np.float32)
    truth = np.full((4, count, count), 32.0, np.float32)
    nearest = np.zeros((count, count), np.float32)
    places = np.arange(count) + 0.5
    for left, top, right, bottom in partly / _STRIDE:
        weight[0, int(top) : int(np.ceil(bottom)), int(left) : int(np.ceil(right))] = 0.0
    for (left, top, right, bottom), kind in zip(corners / _STRIDE, kinds, strict=True):
        x, y, w, h = (left + right) / 2, (top + bottom) / 2, right - left, bottom - top
        across = (places - x) / max(_LEAST_SIGMA, _SIGMA * w)
        down = (places - y) / max(_LEAST_SIGMA, _SIGMA * h)
        bump = np.exp(-0.5 * (across[None] ** 2 + down[:, None] ** 2)).astype(np.float32)
        row, column = min(int(y), count - 1), min(int(x), count - 1)
        bump[row, column] = 1.0
        weight[0, row, column] = 1.0
        mine = bump > nearest
        nearest[mine] = bump[mine]
        truth[:, mine] = np.array([x, y, w, h], np.float32)[:, None] * _STRIDE
        wanted[kind] = np.maximum(wanted[kind], bump)
    truth[2:] = np.maximum(truth[2:], 1.0)
    return wanted, weight, truth


def _coloured(rng: np.random.Generator, crop: Image) -> Image:
    """Return a crop in another light and with other colours."""
    colours = np.eye(3)
    if rng.random() < _EXCHANGED:
        colours = colours[rng.permutation(3)]
    colours = colours * np.exp(rng.normal(0.0, 0.18) + rng.normal(0.0, 0.08, (3, 1)))
    if rng.random() < _FADED:
        colours += rng.random() * (colours.mean(0) - colours)
    offset = np.full((3, 1), rng.normal(0.0, 8.0))
    made = cv2.transform(crop, np.hstack([colours, offset]))
    if rng.random() < _NOISY:
        noise = rng.standard_normal(made.shape, dtype=np.float32)
        made = np.clip(made + np.float32(rng.uniform(0.0, 6.0)) * noise, 0.0, 255.0)
    return np.asarray(made, dtype=np.uint8)
