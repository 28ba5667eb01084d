# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cameras from the 35 mm equivalent focal length that makers state."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import CameraError

FULL_FRAME_DIAGONAL_MM = math.hypot(36.0, 24.0)
"""Diagonal of 35 mm film: makers state focal lengths that give the same diagonal view on it."""


def from_equivalent(
    equivalent_mm: float, photo: tuple[int, int], image: tuple[int, int], zoom: float = 1.0
) -> CameraModel:
    """Return a pinhole camera of a 35 mm equivalent focal length, as makers state it.

    The equivalent refers to the photo's diagonal. An image with a wider aspect ratio than the photo
    (16:9 video) is assumed to have its full width without rows above and below, a narrower one its
    full height.

    Args:
        equivalent_mm: focal length, mm, equivalent on 36 x 24 mm film.
        photo: width and height of the full photo, px; only its aspect ratio matters.
        image: width and height of the images used, px.
        zoom: factor on it.

    Raises:
        CameraError: a value that is not positive.
    """
    if not (math.isfinite(zoom) and zoom > 0.0):
        raise CameraError(f"The zoom must be above 0, not {zoom:g}.")
    diagonal = math.hypot(*photo)
    widest = image[0] * photo[1] >= image[1] * photo[0]
    side = photo[0] if widest else photo[1]
    film_mm = FULL_FRAME_DIAGONAL_MM * side / diagonal
    sensor_width_mm = film_mm if widest else film_mm * image[0] / image[1]
    return CameraModel.from_focal_length(
        equivalent_mm * zoom * 1e-3, sensor_width_mm * 1e-3, None, image[0], image[1]
    )
