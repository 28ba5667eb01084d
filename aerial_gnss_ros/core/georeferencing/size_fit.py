# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How boxes' sizes compare with the lengths stated for their class: of an image, and of a track."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SizeFit:
    """Sizes of the n boxes of an image against the lengths of their class.

    Attributes:
        shortfall: (n,) logarithm of the least diagonal of a robot over the box's; -inf: no length
            is stated for the class.
        excess: (n,) logarithm of the box's longer side over the greatest length; likewise.
        shared_variance: (n,) of both logarithms, what the boxes of one robot have in common: its
            shape and what shows of it, range and height.
        white_variance: (n,) what changes from image to image: the box's edges.
        whole: (n,) whether the box is not cut off by the image's border.
    """

    shortfall: Array
    excess: Array
    shared_variance: Array
    white_variance: Array
    whole: NDArray[np.bool_]

    def of(self, index: int) -> SizeSums:
        """Return the sums of one box: none if it may be cut off."""
        if not self.whole[index]:
            return NO_SIZES
        return SizeSums(
            1,
            float(self.shortfall[index]),
            float(self.excess[index]),
            float(self.shared_variance[index]),
            float(self.white_variance[index]),
        )


@dataclass(frozen=True)
class SizeSums:
    """Sums over the whole boxes of a track (`SizeFit`).

    Attributes:
        count: number of these boxes.
        shortfall, excess, shared_variance, white_variance: sums.
    """

    count: int = 0
    shortfall: float = 0.0
    excess: float = 0.0
    shared_variance: float = 0.0
    white_variance: float = 0.0

    def __add__(self, other: SizeSums) -> SizeSums:
        """Return the sums over the boxes of both."""
        return SizeSums(
            self.count + other.count,
            self.shortfall + other.shortfall,
            self.excess + other.excess,
            self.shared_variance + other.shared_variance,
            self.white_variance + other.white_variance,
        )


NO_SIZES = SizeSums()
