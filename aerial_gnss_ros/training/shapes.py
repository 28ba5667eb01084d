# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random outlines and colours of things that are no robot."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
_FINE = 4  # pixels of the mask for a pixel of the image


def shape(rng: np.random.Generator, length: float) -> F32:
    """Return the coverage (side, side), 0 to 1, of a thing about `length` px long."""
    side = int(1.3 * length) + 6
    mask = np.zeros((side * _FINE, side * _FINE), np.uint8)
    middle, unit = np.full(2, side * _FINE / 2.0), length * _FINE
    kind = int(rng.integers(5))
    if kind == 0:  # a ring
        radius = round(unit * rng.uniform(0.25, 0.45))
        width = max(1, round(radius * rng.uniform(0.2, 0.6)))
        cv2.circle(mask, _point(middle), radius, 255, width)
    elif kind == 1:  # a plank, a pole
        points = cv2.boxPoints((
            (float(middle[0]), float(middle[1])),
            (unit, unit * float(np.exp(rng.uniform(np.log(0.06), np.log(0.3))))),
            float(rng.uniform(0.0, 180.0)),
        ))  # fmt: skip
        cv2.fillPoly(mask, [np.round(points).astype(np.int32)], 255)
    elif kind == 2:  # a star or stone: a polygon without order
        count = int(rng.integers(3, 14))
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
        reach = unit / 2.0 * rng.uniform(0.35, 1.0, count)
        points = middle + reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        cv2.fillPoly(mask, [np.round(points).astype(np.int32)], 255)
    else:  # a body of some lumps, with limbs
        for _ in range(int(rng.integers(1, 5))):
            at = middle + rng.normal(0.0, 0.12 * unit, 2)
            axes = np.maximum(1, np.round(unit * rng.uniform(0.07, 0.27, 2))).astype(int)
            turn = float(rng.uniform(0.0, 180.0))
            cv2.ellipse(mask, _point(at), _point(axes), turn, 0.0, 360.0, 255, -1)
        for _ in range(int(rng.integers(0, 6)) if kind == 4 else 0):
            end = middle + rng.normal(0.0, 0.3 * unit, 2)
            joint = (middle + end) / 2.0 + rng.normal(0.0, 0.08 * unit, 2)
            width = max(1, round(unit * rng.uniform(0.03, 0.12)))
            cv2.polylines(
                mask, [np.round([middle, joint, end]).astype(np.int32)], False, 255, width
            )
    coverage = cv2.resize(mask, (side, side), interpolation=cv2.INTER_AREA)
    return np.asarray(coverage / np.float32(255.0), dtype=np.float32)


def _point(values: NDArray[np.generic]) -> tuple[int, int]:
    """Return a position in whole pixels."""
    x, y = (round(float(value)) for value in values)
    return x, y


def texture(rng: np.random.Generator, size: tuple[int, int], grain: float) -> F32:
    """Return colours (height, width, 3) of a thing: patches of one to four colours, and noise.

    Args:
        rng: all randomness.
        size: width and height, px.
        grain: size of a patch, px.
    """
    width, height = size
    count = int(rng.integers(1, 5))
    colours = rng.uniform(0.0, 255.0, (count, 3)) ** 1.2 / 255.0**0.2
    bright = rng.random() < 0.3  # as rescue colours are: one channel is almost full
    if bright:
        colours[0, int(rng.integers(3))] = 250.0
    fields = np.stack([field(rng, size, grain) for _ in range(count)])
    made = colours[fields.argmax(axis=0)].astype(np.float32)
    if rng.random() < 0.7:
        light = field(rng, size, max(2.0, grain / 2)) * rng.uniform(0.05, 0.35)
        made *= np.exp(light)[..., None]
    made += rng.normal(0.0, rng.uniform(0.0, 12.0), (height, width, 1)).astype(np.float32)
    return np.asarray(np.clip(made, 0.0, 255.0), dtype=np.float32)


def field(rng: np.random.Generator, size: tuple[int, int], grain: float) -> F32:
    """Return a smooth random field (height, width) of unit variance."""
    width, height = size
    coarse = (max(2, round(width / grain) + 1), max(2, round(height / grain) + 1))
    nodes = rng.standard_normal(coarse[::-1]).astype(np.float32)
    return np.asarray(cv2.resize(nodes, size, interpolation=cv2.INTER_CUBIC), np.float32)
