# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar Gaussians in closed form: Mahalanobis distances, inverses, gates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def gate_threshold(probability: float) -> float:
    """Return the squared Mahalanobis distance that contains a share of a planar Gaussian.

    The chi-square law with two degrees of freedom has a closed form.
    """
    return -2.0 * math.log1p(-probability)


def mahalanobis(offsets: Array, covariances: Array) -> tuple[Array, Array]:
    """Return squared Mahalanobis lengths and log determinants of planar offsets.

    Args:
        offsets: (..., 2) m.
        covariances: (..., 2, 2) m².
    """
    a, b, d = covariances[..., 0, 0], covariances[..., 0, 1], covariances[..., 1, 1]
    determinant = np.maximum(a * d - b * b, 1e-24)
    x, y = offsets[..., 0], offsets[..., 1]
    squared = (d * x * x - 2.0 * b * x * y + a * y * y) / determinant
    return squared, np.log(determinant)


def within(part: Array, whole: Array) -> Array:
    """Return a covariance (2, 2), scaled down so far that `whole` minus it is one as well.

    Args:
        part: (2, 2) what the whole should contain.
        whole: (2, 2).
    """
    share = np.linalg.eigvals(np.linalg.pinv(whole, hermitian=True) @ part).real.max()
    found: Array = part / max(1.0, float(share))
    return found


def inverse(covariances: Array) -> Array:
    """Return the inverses (..., 2, 2) of planar covariances, symmetric to the last bit.

    LAPACK's are not, and with them a filter's covariance loses its symmetry within seconds.
    """
    a, b, d = covariances[..., 0, 0], covariances[..., 0, 1], covariances[..., 1, 1]
    determinant = np.maximum(a * d - b * b, 1e-24)
    found = np.empty(covariances.shape)
    found[..., 0, 0], found[..., 1, 1] = d / determinant, a / determinant
    found[..., 0, 1] = found[..., 1, 0] = -b / determinant
    return found
