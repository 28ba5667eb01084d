# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes one variant of a labelled image: random operations in random order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.training import geometry_operations as geometry
from aerial_gnss_ros.training import pixel_operations as pixels
from aerial_gnss_ros.training.carrying import carry, cut, moved, rectangle
from aerial_gnss_ros.training.geometry_operations import GeometryOperation, Size
from aerial_gnss_ros.training.pixel_operations import Image, PixelOperation

Array = NDArray[np.float64]

GEOMETRY: dict[str, GeometryOperation] = {
    "rotation": geometry.rotation,
    "flip_horizontal": geometry.flip_horizontal,
    "flip_vertical": geometry.flip_vertical,
    "crop": geometry.crop,
    "pad": geometry.pad,
    "affine": geometry.affine,
}
PIXELS: dict[str, PixelOperation] = {
    "motion_blur": pixels.motion_blur,
    "glass_blur": pixels.glass_blur,
    "gaussian_blur": pixels.gaussian_blur,
    "brightness": pixels.brightness,
    "colour_temperature": pixels.colour_temperature,
}
# The paper names the operations, and says that each has a probability, but not which.
PROBABILITIES: dict[str, float] = {
    "rotation": 0.5, "flip_horizontal": 0.5, "flip_vertical": 0.5, "crop": 0.3, "pad": 0.2,
    "affine": 0.5, "motion_blur": 0.2, "glass_blur": 0.2, "gaussian_blur": 0.2, "brightness": 0.5,
    "colour_temperature": 0.5,
}  # fmt: skip
SIDE = 1280


@dataclass(frozen=True)
class Recipe:
    """Settings of variants.

    Attributes:
        probabilities: of each operation, drawn independently.
        size: width and height that a finished image is cropped to where it is larger, px.

    Raises:
        ConfigError: an unknown operation, or no probability.
    """

    probabilities: Mapping[str, float] = field(default_factory=lambda: dict(PROBABILITIES))
    size: Size = (SIDE, SIDE)

    def __post_init__(self) -> None:
        for name, value in self.probabilities.items():
            if name not in PROBABILITIES:
                raise ConfigError(
                    f"there is no augmentation {name!r}; choose from {', '.join(PROBABILITIES)}."
                )
            if not 0.0 <= value <= 1.0:
                raise ConfigError(
                    f"the probability of {name} must lie within 0 to 1, but is {value:g}."
                )


@dataclass(frozen=True)
class Variant:
    """An augmented image.

    Attributes:
        image: (height, width, 3) blue, green, red.
        boxes: (n, 4) centre x, y, width, height, px, first pixel spans 0 to 1; in the order of
            the boxes that were given.
    """

    image: Image
    boxes: Array


def make_variant(
    image: Image, boxes: Array, recipe: Recipe, rng: np.random.Generator
) -> Variant | None:
    """Return a variant, or None where a box's centre has left the image.

    Args:
        image: (height, width, 3) blue, green, red.
        boxes: (n, 4) centre x, y, width, height, px, first pixel spans 0 to 1.
        recipe: how it is made.
        rng: random numbers; the same ones make the same variant.
    """
    drawn = [n for n in PROBABILITIES if rng.random() < recipe.probabilities.get(n, 0.0)]
    order = [drawn[i] for i in rng.permutation(len(drawn))]
    canvas = _Canvas(image, boxes)
    for name in order:
        if name in GEOMETRY:
            canvas.move(*GEOMETRY[name](rng, canvas.size, canvas.centres))
        else:
            canvas.warp()
            canvas.image = PIXELS[name](rng, canvas.image)
    canvas.move(*geometry.crop_to(rng, canvas.size, canvas.centres, recipe.size))
    canvas.warp()
    if canvas.lost:
        return None
    return Variant(canvas.image, carry(boxes, canvas.matrix, canvas.seen))


class _Canvas:
    """An image being processed: consecutive warps are merged, which blurs and crops it least."""

    def __init__(self, image: Image, boxes: Array) -> None:
        self.image = image
        self.size: Size = (image.shape[1], image.shape[0])
        self.matrix = np.eye(3)  # from the labelled image
        self.seen = rectangle(*self.size)  # what is left of the labelled image, as an outline
        self.centres = boxes[:, :2].copy()
        self.lost = False
        self._pending = np.eye(3)  # not yet done to the pixels
        # New water has the dominant colour. Mirrored borders would show unlabelled robots, black
        # ones edges that do not exist at sea.
        self._fill = tuple(float(v) for v in np.median(image[::4, ::4].reshape(-1, 3), axis=0))

    def move(self, matrix: Array, size: Size) -> None:
        """Map the canvas to another one."""
        self.matrix, self._pending = matrix @ self.matrix, matrix @ self._pending
        self.centres = moved(self.centres, matrix)
        self.size = size

    def warp(self) -> None:
        """Apply the pending warp to the pixels; parts outside are lost."""
        if np.array_equal(self._pending, np.eye(3)) and self._shape() == self.size:
            return
        self.seen = cut(moved(self.seen, self._pending), rectangle(*self.size))
        inside = (self.centres >= 0.0) & (self.centres < self.size)
        self.lost = self.lost or not bool(inside.all()) or not len(self.seen)
        half = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
        # In OpenCV the centre of the first pixel is (0, 0).
        opencv = (half @ self._pending @ np.linalg.inv(half))[:2]
        warped = cv2.warpAffine(
            self.image,
            opencv,
            self.size,
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=self._fill,
        )
        self.image = np.asarray(warped, dtype=np.uint8)
        self._pending = np.eye(3)

    def _shape(self) -> Size:
        return self.image.shape[1], self.image.shape[0]
