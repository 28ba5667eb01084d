# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Clocks of drones that differ: by how much shows in robots that move.

A drone whose clock is ahead by c stamps an image with t what the others stamp with t - c, and shows
a robot of velocity v at x - c v. Camera and telemetry of one drone have one clock, so that is all
that c does: the camera's pose belongs to the image. In `SharedState`, c is in the place of the
latency, which the drone's own estimator has dealt with. The first drone's clock is the fleet's.

For an image, robots are brought to where its drone shows them, and back after the update. Both maps
use the velocities of before: one from each estimate would let their noise tell of c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClocksTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    sigma_s: float = 0.2
    """One sigma of a clock's offset to the first drone's, s. Clocks set by GNSS or NTP agree to
    some milliseconds, others do not to seconds. Judged."""
    least_sigmas: float = 2.0
    """Offset, in units of `sigma_s`, from which it may well be larger than estimated: the prior
    holds it back, and robots tell little of it. Judged: 1 s is estimated as 0.5 s."""
    said_s: float = 0.05
    """Offset from which it is said, s."""
    sure_sigmas: float = 4.0
    """Sigmas by which it must be larger than that: estimated velocities lag, so that sigmas below
    0.02 s are too small. Judged."""


TUNING = ClocksTuning()


@dataclass(frozen=True)
class ClockOffset:
    """By how much a drone's clock is ahead of the others'.

    Attributes:
        ahead_s: offset, s; NaN without others.
        sigma_s: one sigma of it, s.
    """

    ahead_s: float
    sigma_s: float

    @property
    def said(self) -> bool:
        """Whether it surely is so large that it is said."""
        return abs(self.ahead_s) > TUNING.said_s + TUNING.sure_sigmas * self.sigma_s

    @property
    def words(self) -> str:
        """Return a clause that says it."""
        side = "ahead of" if self.ahead_s > 0.0 else "behind"
        size = f"{abs(self.ahead_s):.2f} s"
        if abs(self.ahead_s) > TUNING.least_sigmas * TUNING.sigma_s:
            size = f"{size} or more"
        return f"its clock is {size} {side} the others'"


NO_OFFSET = ClockOffset(math.nan, math.nan)
"""Of a drone without others."""


def clock_offset(state: SharedState, drone: int, drones: int) -> ClockOffset:
    """Return a drone's clock offset to the other one's; of three and more, to the median of all.

    Args:
        state: the filter.
        drone: number of the drone.
        drones: number of all.
    """
    if drones < 2:
        return NO_OFFSET
    mean, P = state.platforms()
    places = LATENCY + COUNT * np.arange(drones)
    weights = np.zeros(drones)
    if drones == 2:
        weights[1 - drone] = -1.0
    else:
        order = np.argsort(mean[places], kind="stable")
        middle = order[(drones - 1) // 2 : drones // 2 + 1]
        weights[middle] = -1.0 / len(middle)
    weights[drone] += 1.0
    variance = float(weights @ P[np.ix_(places, places)] @ weights)
    return ClockOffset(float(weights @ mean[places]), math.sqrt(max(variance, 0.0)))
