# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws figures of random parts and colours, as examples of distinct things that are no robot.

Outlier exposure (Hendrycks, Mazeika and Dietterich, "Deep anomaly detection with outlier
exposure", ICLR 2019): swimmers, boats and buoys differ in countless ways from robots and from each
other. A figure is a body with parts of other colours on it and around it, half of them symmetric as
people, boats and robots are; it may bear the paints of a robot in another order. What is left to
tell robots by is their own shape and layout.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image

F32 = NDArray[np.float32]
_FINE = 4  # pixels of the drawing for a pixel of the image
_CORNERS = 48  # of a smooth outline


def outline(rng: np.random.Generator, middle: NDArray[np.float64], reach: float, slender: float
) -> NDArray[np.int32]:  # fmt: skip
    """Return the corners (n, 2) of a smooth or an angular random outline.

    Args:
        rng: all randomness.
        middle: of the outline, px.
        reach: half its length, px.
        slender: its width by its length.
    """
    if rng.random() < 0.25:  # angular
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(3, 9))))
        radius = rng.uniform(0.5, 1.0, len(angle))
    else:
        angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
        orders = np.arange(1, 6)
        sizes = rng.normal(0.0, rng.uniform(0.0, 0.25), 5) / orders
        radius = 1.0 + np.cos(orders * angle[:, None] + rng.uniform(0.0, 7.0, 5)) @ sizes
        radius = np.maximum(radius, 0.2) / radius.max()
    turn = rng.uniform(0.0, 2.0 * np.pi)
    along = radius * np.cos(angle) * reach
    across = radius * np.sin(angle) * reach * slender
    points = np.stack([
        along * np.cos(turn) - across * np.sin(turn), along * np.sin(turn) + across * np.cos(turn)
    ], axis=1)  # fmt: skip
    return np.asarray(np.round(middle + points), dtype=np.int32)


def colour(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a colour (3,): dark as suits, white as boats, bright as vests, or any."""
    kind = rng.random()
    if kind < 0.25:
        return rng.uniform(8.0, 70.0) * rng.uniform(0.7, 1.3, 3)
    if kind < 0.45:
        return np.clip(rng.uniform(170.0, 255.0) * rng.uniform(0.9, 1.1, 3), 0.0, 255.0)
    if kind < 0.75:
        bright = rng.uniform(0.0, 120.0, 3)
        bright[rng.permutation(3)[: int(rng.integers(1, 3))]] = rng.uniform(170.0, 255.0)
        return bright
    return rng.uniform(0.0, 255.0, 3)


def figure(
    rng: np.random.Generator, length: float, paints: Sequence[Image] = ()
) -> tuple[F32, F32]:
    """Return a figure about `length` px long.

    Args:
        rng: all randomness.
        length: of the figure, px.
        paints: pictures (h, w, 3) of robots, whose colours it may bear in another order.

    Returns:
        Coverage (side, side), 0 to 1, and colours (side, side, 3), blue, green, red.
    """
    side = int(1.4 * length) + 8
    size, unit = side * _FINE, length * _FINE
    share = np.zeros((size, size), np.float32)
    colours = np.zeros((size, size, 3), np.float32)
    middle = np.full(2, size / 2.0)
    symmetric = rng.random() < 0.5
    reach = unit * rng.uniform(0.25, 0.5)
    slender = float(np.exp(rng.uniform(np.log(0.2), 0.0)))
    painted = len(paints) > 0 and rng.random() < 0.6
    _paint(share, colours, [outline(rng, middle, reach, slender)], colour(rng), 1.0)
    for _ in range(int(rng.integers(0, 9))):
        away = rng.normal(0.0, 0.55, 2) * reach
        half = reach * float(np.exp(rng.uniform(np.log(0.15), np.log(0.7))))
        part = outline(rng, middle + away, half, float(rng.uniform(0.15, 1.0)))
        parts = [part]
        if symmetric:
            parts.append((np.array([size, 0]) - part * np.array([1, -1])).astype(np.int32))
        shown = 1.0 if rng.random() < 0.7 else float(rng.uniform(0.3, 1.0))  # under water
        _paint(share, colours, parts, colour(rng), shown)
    turn = cv2.getRotationMatrix2D((size / 2.0, size / 2.0), float(rng.uniform(0.0, 360.0)), 1.0)
    share = np.asarray(cv2.warpAffine(share, turn, (size, size)), np.float32)
    colours = np.asarray(cv2.warpAffine(colours, turn, (size, size)), np.float32)
    small = (side, side)
    covered = np.asarray(cv2.resize(share, small, interpolation=cv2.INTER_AREA), np.float32)
    if painted:
        made = reordered(rng, paints[int(rng.integers(len(paints)))], side)
    else:
        made = np.asarray(cv2.resize(colours, small, interpolation=cv2.INTER_AREA), np.float32)
        inside = np.asarray(
            cv2.resize((share > 0).astype(np.float32), small, interpolation=cv2.INTER_AREA)
        )
        made /= np.maximum(inside, 1.0 / _FINE**2)[..., None]  # no black seam
    nodes = rng.normal(0.0, rng.uniform(0.0, 0.3), (4, 4))
    light = np.exp(cv2.resize(nodes, small, interpolation=cv2.INTER_CUBIC))[..., None]
    noise = rng.normal(0.0, rng.uniform(0.0, 10.0), made.shape)
    return covered, np.asarray(np.clip(made * light + noise, 0.0, 255.0), np.float32)


def _paint(
    share: F32, colours: F32, parts: Sequence[NDArray[np.int32]], paint: NDArray[np.float64],
    shown: float,
) -> None:  # fmt: skip
    mask = np.zeros(share.shape, np.uint8)
    for part in parts:
        cv2.fillPoly(mask, [part], 255)
    on = mask > 0
    colours[on] = paint
    share[on] = np.maximum(share[on], shown)


def reordered(rng: np.random.Generator, picture: Image, side: int) -> F32:
    """Return the colours (side, side, 3) of a picture, cut into tiles that lie in another order."""
    count = int(rng.integers(2, 5))
    tile = max(2, round(max(picture.shape[:2]) / count))
    whole = cv2.resize(picture, (count * tile, count * tile)).astype(np.float32)
    rows = whole.reshape(count, tile, count, tile, 3).transpose(0, 2, 1, 3, 4)
    tiles = rows.reshape(count * count, tile, tile, 3)[rng.permutation(count * count)]
    turned = [np.rot90(one, int(rng.integers(4))) for one in tiles]
    lines = [np.hstack(turned[i * count : (i + 1) * count]) for i in range(count)]
    made = np.vstack(lines)
    if rng.random() < 0.5:
        made = made[..., rng.permutation(3)]
    made = made * float(np.exp(rng.normal(0.0, 0.25)))
    return np.asarray(cv2.resize(made, (side, side)), np.float32)
