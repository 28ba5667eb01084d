# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image's result with its surroundings, for a person who watches."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.reference_place import ReferencePlace
from aerial_gnss_ros.core.values.samples import Array


@dataclass(frozen=True)
class Overview:
    """One image's result with its surroundings.

    Attributes:
        result: of the image; robots in the order of its `estimates`.
        footprint: (n, 2) latitude, longitude of the water that the image shows, along its edge,
            rad; (0, 2) if that is unknown.
        pixels: (k, 2) u, v of each robot's estimated position in the image, px; NaN where it is not
            in the image.
        depths: (k,) depth of each robot below the surface as used, m.
        references: where objects of known position are.
        image_size: (width, height) of the image, px; None if the camera is unknown.
    """

    result: FrameResult
    footprint: Array
    pixels: Array
    depths: Array
    references: tuple[ReferencePlace, ...] = ()
    image_size: tuple[int, int] | None = None
