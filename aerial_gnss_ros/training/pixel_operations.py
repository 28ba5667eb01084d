# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Augmentations that change pixels but move nothing: blurs, brightness, colour of the light.

All blurs are centred, so boxes stay. Lengths are in pixels of the image as it is.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.training.colour import table

Image = NDArray[np.uint8]
PixelOperation = Callable[[np.random.Generator, Image], Image]
"""(random numbers, image (height, width, 3) blue, green, red) -> image of the same size."""

MOTION_PX = (3, 15)
GLASS_PX = (1, 3)
GAUSSIAN_PX = (0.5, 2.0)
BRIGHTNESS = (0.6, 1.4)
KELVIN = (4000.0, 20000.0)


def motion_blur(rng: np.random.Generator, image: Image) -> Image:
    """Blur along a line of MOTION_PX in any direction: a drone or robot that moves."""
    length, angle = rng.uniform(*MOTION_PX), rng.uniform(0.0, np.pi)
    side = 2 * (MOTION_PX[1] // 2) + 3
    middle = (side - 1) / 2
    half = 0.5 * (length - 1.0) * np.array([np.cos(angle), np.sin(angle)])
    # Sixteenths of pixels; symmetric about the middle, so that nothing is shifted.
    ends = [tuple(round(16 * (middle + s * h)) for h in half) for s in (-1.0, 1.0)]
    kernel = np.zeros((side, side), dtype=np.uint8)
    cv2.line(kernel, ends[0], ends[1], 255, 1, cv2.LINE_AA, shift=4)
    weights = kernel.astype(np.float64) + kernel[::-1, ::-1]
    return _uint8(cv2.filter2D(image, -1, weights / weights.sum(), borderType=cv2.BORDER_REFLECT))


def glass_blur(rng: np.random.Generator, image: Image) -> Image:
    """Move each pixel by a random offset of up to GLASS_PX, between two blurs.

    Like light scattered by ruffled water; D. Hendrycks and T. Dietterich, Benchmarking neural
    network robustness to common corruptions, ICLR 2019, but with independent draws.
    """
    reach, sigma = int(rng.integers(GLASS_PX[0], GLASS_PX[1] + 1)), rng.uniform(0.7, 1.2)
    height, width = image.shape[:2]
    soft = _gaussian(image, sigma)
    offsets = rng.integers(-reach, reach + 1, (2, height, width), dtype=np.int16)
    x = np.clip(np.arange(width, dtype=np.int16) + offsets[0], 0, width - 1)
    y = np.clip(np.arange(height, dtype=np.int16)[:, None] + offsets[1], 0, height - 1)
    return _gaussian(soft[y, x], sigma)


def gaussian_blur(rng: np.random.Generator, image: Image) -> Image:
    """Blur with a sigma of GAUSSIAN_PX: out of focus."""
    return _gaussian(image, rng.uniform(*GAUSSIAN_PX))


def brightness(rng: np.random.Generator, image: Image) -> Image:
    """Multiply all values by BRIGHTNESS: times of day, exposure."""
    return _uint8(cv2.convertScaleAbs(image, alpha=rng.uniform(*BRIGHTNESS)))


def colour_temperature(rng: np.random.Generator, image: Image) -> Image:
    """Light the scene with KELVIN, drawn uniformly in 1/K, as the eye perceives differences."""
    kelvin = 1.0 / rng.uniform(1.0 / KELVIN[1], 1.0 / KELVIN[0])
    return _uint8(cv2.LUT(image, table(kelvin).reshape(1, 256, 3)))


def _gaussian(image: Image, sigma: float) -> Image:
    return _uint8(cv2.GaussianBlur(image, (0, 0), sigma, borderType=cv2.BORDER_REFLECT))


def _uint8(image: object) -> Image:
    return np.asarray(image, dtype=np.uint8)
