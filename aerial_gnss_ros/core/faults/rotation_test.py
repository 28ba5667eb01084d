# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots changed their velocities each by itself, or one turn of the camera explains all.

Two explanations are weighed, in nats:

    robots    sum over robots of the cheaper of: as stated; a swerve
    a turn    the same of what the best turn w leaves, its prior and how finely it must be chosen
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RotationTestTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    swerve_share: float = 0.25
    """Change of velocity within seconds, one sigma of each axis, of a robot that swerves, as a
    share of the fastest speed. Judged."""
    swerve_probability: float = 0.25
    """Share of the time in which a robot swerves: of those that steer. Judged."""
    turn_rate_sigma_radps: float = math.radians(5.0)
    """One sigma of the rate of a camera that turns by itself, each axis, rad/s. Judged."""


TUNING = RotationTestTuning()


def fit_rotation(
    sums: Array, variances: Array, by_angles: Array, swerve: Array | float
) -> tuple[Array, Array, float]:
    """Return the turn (3,) that explains changes of velocity best, and by how much better (nats).

    Args:
        sums: (n, 2) changes of velocity, m/s.
        variances: (n,) of each axis by what is stated, m²/s².
        by_angles: (n, 2, 3) m/rad.
        swerve: one sigma of each axis of a swerve, m/s.

    Returns:
        The turn, rad/s; its covariance (3, 3); logarithm of the odds that there is a turn, with
        equal odds before.
    """
    stated = np.maximum(variances, 1e-8)
    wide = stated + swerve**2
    dear = np.log(wide / stated) - math.log(TUNING.swerve_probability)

    def costs(rest: Array) -> tuple[Array, NDArray[np.bool_]]:
        squared = 0.5 * np.einsum("ij,ij->i", rest, rest)
        one, other = squared / stated, squared / wide + dear
        return np.minimum(one, other), other < one

    def fitted(weight: Array) -> tuple[Array, Array]:
        weighted = by_angles * weight[:, None, None]
        information = (
            np.einsum("nik,nil->kl", weighted, by_angles)
            + np.eye(3) / TUNING.turn_rate_sigma_radps**2
        )
        told = -np.einsum("nik,ni->k", weighted, sums)
        return np.linalg.solve(information, told), information

    robots = float(costs(sums)[0].sum())
    turn, information = fitted(1.0 / stated)
    for _ in range(3):  # robots that swerve beside count less
        swerves = costs(sums + by_angles @ turn)[1]
        turn, information = fitted(1.0 / np.where(swerves, wide, stated))
    left = (
        float(costs(sums + by_angles @ turn)[0].sum())
        + 0.5 * float(turn @ turn) / TUNING.turn_rate_sigma_radps**2
    )
    finely = 0.5 * float(np.linalg.slogdet(information * TUNING.turn_rate_sigma_radps**2)[1])
    spread: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return turn, spread, robots - left - finely
