# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Likelihood ratio test: did robots manoeuvre independently, or did the camera rotate?

Two hypotheses are compared, in nats:

    robots    sum over robots of the cheaper of: the stated motion; a manoeuvre
    rotation  the same for the residuals of the best rotation w, its prior, and an Occam factor
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
    """Change of velocity of a manoeuvring robot within seconds, one sigma, each axis, as a share of
    its greatest speed. Judged."""
    swerve_probability: float = 0.25
    """Share of the time in which a robot manoeuvres. Judged."""
    turn_rate_sigma_radps: float = math.radians(5.0)
    """Rate of an unmeasured rotation of the camera, one sigma, each axis, rad/s. Judged."""


TUNING = RotationTestTuning()


def fit_rotation(
    sums: Array, variances: Array, by_angles: Array, swerve: Array | float
) -> tuple[Array, Array, float]:
    """Return the camera rotation (3,) that best explains velocity changes, and its log odds.

    Args:
        sums: (n, 2) changes of velocity, m/s.
        variances: (n,) of each axis under the stated motion, m²/s².
        by_angles: (n, 2, 3) derivative of positions by the angles, m/rad.
        swerve: velocity change of a manoeuvre, one sigma, each axis, m/s.

    Returns:
        The rotation rate, rad/s; its covariance (3, 3); log odds of a rotation, at even prior odds.
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
        weighted_sum = -np.einsum("nik,ni->k", weighted, sums)
        return np.linalg.solve(information, weighted_sum), information

    robots = float(costs(sums)[0].sum())
    turn, information = fitted(1.0 / stated)
    fitted_swerves = [False] * len(stated)
    for _ in range(3):  # manoeuvring robots count less
        swerves = costs(sums + by_angles @ turn)[1]
        if swerves.tolist() == fitted_swerves:
            break  # the same fit again
        turn, information = fitted(1.0 / np.where(swerves, wide, stated))
        fitted_swerves = swerves.tolist()
    left = (
        float(costs(sums + by_angles @ turn)[0].sum())
        + 0.5 * float(turn @ turn) / TUNING.turn_rate_sigma_radps**2
    )
    finely = 0.5 * float(np.linalg.slogdet(information * TUNING.turn_rate_sigma_radps**2)[1])
    spread: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return turn, spread, robots - left - finely
