# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of the filter's state: finite, symmetric, positive, within bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import StateError
from aerial_gnss_ros.core.values.estimates import RobotEstimate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlausibleStateTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    farthest_m: float = 1e6
    """Greatest distance of a robot from the origin of `map`: no drone flies as far, m."""
    fastest_mps: float = 1e3
    """Greatest speed of a robot, beyond that of anything in the water, m/s."""
    asymmetry_share: float = 1e-6
    """Greatest asymmetry of a covariance, relative to its largest variance. Judged."""


TUNING = PlausibleStateTuning()


@lru_cache(maxsize=64)
def _ones(n: int) -> Array:
    """Return ones (n,)."""
    return np.ones(n)


def check_covariance(covariance: Array, what: str) -> None:
    """Check a covariance (n, n).

    Raises:
        StateError: it is not finite, not symmetric, or a variance is not positive.
    """
    variances = covariance.diagonal().tolist()
    least, most = min(variances), max(variances)
    # Row and column sums show nearly all asymmetries, at a tenth of the time.
    one = _ones(len(variances))
    down, across = one @ covariance, covariance @ one
    if not math.isfinite(sum(down.tolist())):
        raise StateError(f"the covariance of {what} is not finite")
    if least < 0.0:
        raise StateError(f"{what} have a variance of {least:g}")
    uneven = max(np.abs(down - across).tolist())
    if uneven > TUNING.asymmetry_share * most:
        raise StateError(f"the covariance of {what} is not symmetric: it differs by {uneven:g}")


def check_robots(robots: Array, what: str) -> None:
    """Check states (n, 4) of robots: east, north (m), velocities (m/s).

    Raises:
        StateError: one is not finite, or out of bounds.
    """
    numbers = robots.ravel().tolist()
    # Of all together first: where none is large, none is a distance or a speed too large.
    if not numbers or (
        max(numbers) <= TUNING.fastest_mps
        and min(numbers) >= -TUNING.fastest_mps
        and not math.isnan(sum(numbers))
    ):
        return
    east, north, *velocity = np.maximum.reduce(np.abs(robots), axis=0).tolist()
    far, fast = max(east, north), max(velocity)
    if (
        math.isnan(east + north + sum(velocity))
        or far > TUNING.farthest_m
        or fast > TUNING.fastest_mps
    ):
        raise StateError(f"{what} are {far:g} m from the origin of map, at {fast:g} m/s")


def check_estimates(estimates: Sequence[RobotEstimate]) -> None:
    """Check estimates before they are published.

    Raises:
        StateError: a number is not finite, or a variance is not positive.
    """
    if not estimates:
        return
    covariances = np.concatenate([one.covariance for one in estimates]).reshape(-1, 16)
    # Of all together first; NaN or infinite numbers make a sum so.
    diagonals = covariances[:, ::5]
    east, north, *least = map(min, diagonals.T.tolist())
    numbers = float(np.add.reduce(covariances, axis=None))
    for one in estimates:
        numbers += one.latitude + one.longitude
    if east > 0.0 and north > 0.0 and min(least) >= 0.0 and math.isfinite(numbers):
        return
    totals = np.add.reduce(covariances, axis=1).tolist()
    for one, total, variances in zip(estimates, totals, diagonals.tolist(), strict=True):
        east, north, *velocities = variances
        finite = math.isfinite(one.latitude + one.longitude + total)
        if not (finite and min(east, north) > 0.0 and min(velocities) >= 0.0):
            raise StateError(
                f"{one.robot_id} would be published at {one.latitude}, {one.longitude} rad with "
                f"variances {variances}"
            )
