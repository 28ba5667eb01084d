# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the receivers of several drones have in common, before any image.

A receiver's offset is the sum of a part common to all receivers and one of its own. As both have
one correlation time, their sum is kept, and the common part is a covariance between drones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.platform_model import COUNT, GNSS

Array = NDArray[np.float64]


def common_variance(one: Array, other: Array, share: float) -> float:
    """Return the covariance of two receivers' offsets on each axis, m².

    It is that share of the better receiver's variance: what one has removed is not common. With
    the least eigenvalues, the covariance of all drones is positive semidefinite.

    Args:
        one: (2, 2) covariance of a receiver's offset, m².
        other: that of the other one.
        share: part of the variance that is common.
    """
    least = min(np.linalg.eigvalsh(one)[0], np.linalg.eigvalsh(other)[0])
    return share * max(float(least), 0.0)


def joint_prior(stationary: list[Array], share: float) -> Array:
    """Return the prior covariance of several drones' errors (9 N, 9 N).

    Args:
        stationary: (9, 9) of each drone.
        share: part of the receivers' variance that is common.
    """
    whole = np.zeros((COUNT * len(stationary), COUNT * len(stationary)))
    for i, one in enumerate(stationary):
        whole[COUNT * i : COUNT * i + COUNT, COUNT * i : COUNT * i + COUNT] = one
        for j, other in enumerate(stationary[:i]):
            common = common_variance(one[GNSS, GNSS], other[GNSS, GNSS], share)
            for axis in (0, 1):
                rows = COUNT * i + axis, COUNT * j + axis
                whole[rows], whole[rows[::-1]] = common, common
    return whole
