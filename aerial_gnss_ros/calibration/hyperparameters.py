# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Noise of the boxes and sigmas of the processes: of greatest likelihood.

MacKay's fixed point: with g the effective number of unknowns of a process, which the data
determine, its variance is xᵀQx / g (MacKay 1992, Bayesian interpolation). A robot that stays is one
whose speed is estimated as 0.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU

from aerial_gnss_ros.calibration.layout import Layout
from aerial_gnss_ros.calibration.prior import Prior
from aerial_gnss_ros.calibration.unknowns import BOX, CONSTANTS, DRIFT, FIRST_ROBOT, POINTING

Array = NDArray[np.float64]

PROBES = 12
OVERRELAXATION = 1.5
"""The fixed point is approached by small steps in one direction, so longer ones converge sooner."""
STATED_WEIGHT = 10.0
"""Weight of the noise set's sigma of boxes, as a number of residuals."""
LEAST_EFFECTIVE = 1e-6
"""Least effective numbers. Of pointing errors and boxes: small, or a sigma once near 0 would stay
there. Of paths, whose precision is singular: the random signs determine it only to a few
hundredths."""
LEAST = {POINTING: 1e-6, BOX: 0.02}
SPEEDS = (3e-4, 3.0)
PIXELS = (0.2, 500.0)


class Reestimation:
    """Fixed-point iteration of the sigmas.

    Args:
        layout: of the unknowns.
        prior: of the unknowns.
    """

    def __init__(self, layout: Layout, prior: Prior) -> None:
        self._layout, self._prior = layout, prior
        self._signs = np.random.default_rng(1)

    def turn(self, unknowns: Array, sigmas: Array, factor: SuperLU) -> tuple[Array, Array, float]:
        """Return the next sigmas, the effective numbers of unknowns, and that of all drifts.

        Args:
            unknowns: (size,) the most likely ones.
            sigmas: (processes,) so far.
            factor: of their information H.

        Returns:
            sigmas (processes,); effective numbers (processes + 1,), the last that of the receiver's
            drift; the effective number of all drifts together.
        """
        layout, found = self._layout, sigmas.copy()
        effective = np.zeros(layout.processes)
        undetermined, (level, other) = self._undetermined(factor, sigmas)
        for process in range(layout.processes):
            columns, part = self._prior.part(process)
            rank = len(columns) - (2 if process >= FIRST_ROBOT else 0)
            least = 0.02 * rank**0.5 if process >= FIRST_ROBOT else LEAST_EFFECTIVE
            effective[process] = max(rank - undetermined[process], least)
            size = max(float(unknowns @ (part @ unknowns)), 0.0)  # rounding may make it less
            ratio = math.sqrt(size / effective[process]) / sigmas[process]
            value = sigmas[process] * float(np.clip(ratio**OVERRELAXATION, 0.2, 5.0))
            low, high = SPEEDS if process >= FIRST_ROBOT else (LEAST[process], math.inf)
            found[process] = min(max(value, low), high)
        return found, np.append(effective, level), level + other

    def pixel(self, squares: float, count: int, effective: float) -> float:
        """Return one sigma of the boxes' white noise, px.

        Args:
            squares: weighted sum of squared residuals, px².
            count: of boxes.
            effective: number of unknowns that they determine, without constants and ends of paths.
        """
        left = 2.0 * count - effective - len(CONSTANTS) - 2.0 * len(self._layout.paths)
        stated = STATED_WEIGHT * self._prior.pixel**2
        found = math.sqrt((squares + stated) / (max(left, 0.0) + STATED_WEIGHT))
        return min(max(found, PIXELS[0]), PIXELS[1])

    def _undetermined(self, factor: SuperLU, sigmas: Array) -> tuple[Array, tuple[float, float]]:
        """Return the numbers of undetermined unknowns of each process, and of determined ones.

        The latter for the receiver's drift and for the other drifts. Both are traces of a process's
        precision times the covariance, estimated with random signs (Hutchinson 1990).
        """
        kinds = [*range(len(sigmas)), DRIFT]
        signs = np.zeros((self._layout.size, PROBES * len(kinds)))
        parts = [self._prior.part(kind) for kind in kinds]
        for number, (columns, _) in enumerate(parts):
            probes = self._signs.choice((-1.0, 1.0), (len(columns), PROBES))
            signs[columns, number * PROBES : (number + 1) * PROBES] = probes
        solved = factor.solve(signs)
        rows = []
        for number, (columns, part) in enumerate(parts):
            own = slice(number * PROBES, (number + 1) * PROBES)
            rows.append(np.sum(signs[columns, own] * (part @ solved[:, own])[columns], axis=1))
        found = np.array([float(row.sum()) / PROBES for row in rows[:-1]]) / np.square(sigmas)
        determined = 1.0 - rows[-1] / PROBES
        level = self._layout.first_drift[2] - self._layout.first_drift[0]
        receiver, others = float(determined[:level].sum()), float(determined[level:].sum())
        return found, (max(receiver, 0.0), max(others, 0.0))
