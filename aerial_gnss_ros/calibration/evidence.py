# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Marginal likelihood of a recording's boxes, with all functions of time integrated out.

Unknowns x with prior precision Q, residuals r of boxes with noise s: damped Gauss-Newton steps
(Levenberg-Marquardt, because height, tilt and heading are strongly nonlinear) lead to the most
likely x, and with the information H = JᵀJ/s² + Q there,

    log p(boxes) = -1/2 (|r|²/s² + xᵀQx + n log 2πs² + log det H - log det Q)

(Laplace's approximation; exact where the model is linear). All matrices are sparse: unknowns far
apart in time are uncoupled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import SuperLU, splu

from aerial_gnss_ros.calibration.geometry import Predicted
from aerial_gnss_ros.calibration.hyperparameters import Reestimation
from aerial_gnss_ros.calibration.measurement_model import MeasurementModel
from aerial_gnss_ros.calibration.prior import Prior
from aerial_gnss_ros.calibration.unknowns import (
    FIRST_ROBOT,
    FIX_DELAY,
    FOCAL,
    GLOBALS,
    LATENCY,
    PRIOR_SIGMAS,
)

Array = NDArray[np.float64]

HUBER = 2.5
UNSEEN = 30.0
"""Distance, in sigmas, of a box whose robot the model places out of view."""
LONGEST_STEP_S = 0.25
FIRST_DAMPING, DAMPINGS = 10.0, (1e-2, 1e6)
"""Damping of platform errors as a multiple of the prior's precision: initial value and bounds. With
swimming robots, boxes hardly determine height and tilt, and an undamped step goes far beyond the
linear range: by 40 m of height."""
EASED, RAISED = 0.2, 10.0
"""Factors on the damping after a step that succeeds at once, and after one that fails."""
TRIALS = 6
LEAST_GAIN = 0.02
"""Decrease of the cost below which a descent at given noise and sigmas ends."""
HELD = 1e12
"""Precision of a constant that is held."""


@dataclass(frozen=True)
class State:
    """One point of a descent.

    Attributes:
        unknowns: (size,).
        pixel: one sigma of the boxes' white noise, px.
        sigmas: (processes,) see `unknowns.py`.
        distances: (n,) of boxes from the prediction, over the noise.
        cost: of residuals and unknowns.
        log_likelihood: with the unknowns integrated out.
        factor: of H; None before the first step.
        effective: (processes + 1,) effective number of unknowns of each process, the last of the
            receiver's drift; None before the first step.
        damping: of the next step, see `FIRST_DAMPING`.
    """

    unknowns: Array
    pixel: float
    sigmas: Array
    distances: Array
    cost: float
    log_likelihood: float = -math.inf
    factor: SuperLU | None = None
    effective: Array | None = None
    damping: float = FIRST_DAMPING


class Evidence:
    """Likelihood of boxes, and descent to the most likely unknowns.

    Args:
        model: of the boxes.
        prior: of its unknowns.
    """

    def __init__(self, model: MeasurementModel, prior: Prior) -> None:
        self.model, self.prior = model, prior
        self._reestimation = Reestimation(model.layout, prior)

    def start(self, unknowns: Array, pixel: float, sigmas: Array) -> State:
        """Return the state before the first step."""
        state = State(unknowns, pixel, sigmas, np.zeros(0), math.inf)
        return self._with_cost(
            state, self.model.predicted(unknowns), self.prior.precision(sigmas)[0]
        )

    def descend(self, state: State, steps: int, held: frozenset[int], adapt: bool = True) -> State:
        """Return the state after some Gauss-Newton steps.

        Args:
            state: initial state.
            steps: greatest number of steps.
            held: constants that keep their values.
            adapt: also estimate noise and sigmas.
        """
        for _ in range(steps):
            before = state
            state = self._step(state, held)
            if adapt:
                state = self._adapted(state)
            if not adapt and abs(state.cost - before.cost) < LEAST_GAIN:
                break
        return self.evaluated(state, held)

    def evaluated(self, state: State, held: frozenset[int]) -> State:
        """Return the state with its likelihood, for its noise and sigmas."""
        found = self.model.predicted(state.unknowns)
        prior, log_det = self.prior.precision(state.sigmas)
        state = self._with_cost(state, found, prior)
        information, _ = self._normal(state, found, prior, held)
        factor = _factor(information)
        whole = float(np.sum(np.log(np.abs(factor.U.diagonal()))))
        # A held constant is no unknown: its entry of H cancels, and its precision does not count.
        log_det += sum(math.log(HELD * PRIOR_SIGMAS[one] ** 2) for one in held)
        boxes = 2.0 * len(self.model.tracks) * math.log(state.pixel * math.sqrt(2.0 * math.pi))
        volume = 2.0 * float(self._shares(state) @ found.area)  # already in the determinant
        value = -0.5 * (state.cost - volume + whole - log_det) - boxes
        return replace(state, log_likelihood=value, factor=factor)

    def covariance(self, state: State, picks: Array) -> Array:
        """Return the covariance of some linear functions (k, size) of the unknowns."""
        assert state.factor is not None  # noqa: S101
        return np.asarray(picks @ state.factor.solve(np.ascontiguousarray(picks.T)))

    def slopes(self, state: State, picks: Array, wanted: list[int], held: frozenset[int]) -> Array:
        """Return derivatives (k, m) of linear functions (k, size) of the fit by held constants."""
        assert state.factor is not None  # noqa: S101
        found = self.model.predicted(state.unknowns)
        prior, _ = self.prior.precision(state.sigmas)
        open_, _ = self._normal(state, found, prior, frozenset())
        pull = -np.asarray(open_[:, wanted].todense())
        pull[list(held)] = 0.0
        return np.asarray(picks @ state.factor.solve(np.ascontiguousarray(pull)))

    def _step(self, state: State, held: frozenset[int]) -> State:
        found = self.model.predicted(state.unknowns)
        prior, _ = self.prior.precision(state.sigmas)
        state = self._with_cost(state, found, prior)
        information, gradient = self._normal(state, found, prior, held)
        damping = state.damping
        for trial in range(TRIALS):
            factor = _factor(information + self._damped(damping))
            step = factor.solve(gradient)
            far = max(abs(float(step[LATENCY])), abs(float(step[FIX_DELAY])), 1e-9)
            share = min(1.0, LONGEST_STEP_S / far)
            tried = self._moved(state, state.unknowns + share * step, prior)
            if tried.cost > state.cost:
                tried = self._along(tried, prior)
            if tried.cost <= state.cost + 1e-6 * abs(state.cost):
                eased = max(damping * (EASED if trial == 0 else 0.5), DAMPINGS[0])
                return replace(tried, factor=factor, damping=eased)
            damping = min(damping * RAISED, DAMPINGS[1])
        return replace(state, factor=factor, damping=damping)

    def _damped(self, damping: float) -> csc_matrix:
        """Return the damping's contribution to the information."""
        firm = np.zeros(self.model.layout.size)
        firm[FOCAL:GLOBALS] = damping / np.square(PRIOR_SIGMAS[FOCAL:])
        return diags(firm, format="csc")

    def _along(self, state: State, prior: csc_matrix) -> State:
        """Return the state with the constants held and all other unknowns solved for again.

        A step in height or roll moves the robots' positions beyond the linear range, so they must
        be solved for again.
        """
        found = self.model.predicted(state.unknowns)
        information, gradient = self._normal(state, found, prior, frozenset(range(GLOBALS)))
        return self._moved(state, state.unknowns + _factor(information).solve(gradient), prior)

    def _moved(self, state: State, unknowns: Array, prior: csc_matrix) -> State:
        return self._with_cost(
            replace(state, unknowns=unknowns), self.model.predicted(unknowns), prior
        )

    def _adapted(self, state: State) -> State:
        """Return the state after one fixed-point iteration of sigmas and noise."""
        assert state.factor is not None  # noqa: S101
        sigmas, effective, drifts = self._reestimation.turn(
            state.unknowns, state.sigmas, state.factor
        )
        squares = float(np.sum(_weights(state.distances) * np.square(state.distances)))
        pixel = self._reestimation.pixel(
            squares * state.pixel**2, len(self.model.tracks),
            float(np.sum(effective[:-1])) + drifts,
        )  # fmt: skip
        return replace(state, sigmas=sigmas, pixel=pixel, effective=effective)

    def _with_cost(self, state: State, found: Predicted, prior: csc_matrix) -> State:
        """Return the state with distances and cost of a prediction."""
        off = np.linalg.norm(found.values, axis=1) / state.pixel
        distances = np.where(np.isfinite(off), off, UNSEEN)
        inner = np.minimum(distances, HUBER)
        robust = float(np.sum(inner * (2.0 * distances - inner)))
        x = state.unknowns
        volume = 2.0 * float(self._shares(state) @ found.area)
        return replace(state, distances=distances, cost=robust + volume + float(x @ (prior @ x)))

    def _shares(self, state: State) -> Array:
        """Return half the effective number of unknowns in metres per box, (n,)."""
        if state.effective is None:
            return np.zeros(len(self.model.tracks))
        counts = np.bincount(self.model.tracks)
        share: Array = (
            0.5 * state.effective[FIRST_ROBOT:-1][self.model.tracks] / counts[self.model.tracks]
        )
        return share + 0.5 * float(state.effective[-1]) / len(self.model.tracks)

    def _normal(
        self, state: State, found: Predicted, prior: csc_matrix, held: frozenset[int]
    ) -> tuple[csc_matrix, Array]:
        """Return the information on the unknowns and the gradient."""
        values = np.nan_to_num(found.values)
        seen = np.isfinite(found.values).all(axis=1)
        weight = np.sqrt(_weights(state.distances) * seen) / state.pixel
        jacobian = self.model.jacobian(found, weight)
        firm = np.zeros(self.model.layout.size)
        firm[list(held)] = HELD
        information = csc_matrix(jacobian.T @ jacobian) + prior + diags(firm, format="csc")
        gradient = jacobian.T @ (values * weight[:, None]).ravel() - prior @ state.unknowns
        gradient -= self.model.gradient_by_errors(
            self._shares(state)[:, None] * found.area_by_error
        )
        return information, np.asarray(gradient)


def _weights(distances: Array) -> Array:
    return np.asarray(np.minimum(1.0, HUBER / np.maximum(distances, 1e-9)))


def _factor(information: csc_matrix) -> SuperLU:
    return splu(
        information, permc_spec="COLAMD", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
