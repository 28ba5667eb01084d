# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stated position of a reference at the time of an image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReferencePlace:
    """An object of known position.

    Attributes:
        name: of the reference.
        class_id: class name as the detector gives it.
        latitude: rad, WGS84.
        longitude: rad, WGS84.
        covariance: (2, 2) East, North of that position, m².
        height: of what its box shows, above the water, m.
        moves: whether it holds for this image only.
    """

    name: str
    class_id: str
    latitude: float
    longitude: float
    covariance: Array
    height: float = 0.0
    moves: bool = False
