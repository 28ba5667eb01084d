# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The likelihood of a recording's boxes with everything that changes in time integrated out.

Unknowns x with precision Q before the data, residuals r of boxes with noise s: Gauss-Newton steps
lead to the most likely x, and with the information H = JᵀJ/s² + Q there,

    log p(boxes) = -1/2 (|r|²/s² + xᵀQx + n log 2πs² + log det H - log det Q)

(Laplace's approximation; exact where the model is linear). Strengths of processes and the noise are
where this is largest, by MacKay's fixed point: with g the number of unknowns of a process that the
data tell, its variance is xᵀQx / g (MacKay 1992, Bayesian interpolation). A robot that stays is one
whose speed comes out as 0. All matrices are sparse: what is far apart in time does not meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import SuperLU, splu

from aerial_gnss_ros.calibration.geometry import Boxes, Predicted, predicted
from aerial_gnss_ros.calibration.layout import (
    BEFORE,
    BOX,
    CONSTANTS,
    DRIFT,
    EXTRA,
    FAST,
    FIRST_ERROR,
    FIRST_ROBOT,
    FOCAL,
    GLOBALS,
    LATENCY,
    Layout,
)
from aerial_gnss_ros.calibration.motion import ERRORS, Motion, Poses, Stamps

Array = NDArray[np.float64]

HUBER = 2.5
LOST = 30.0
"""A box that the model does not see at all counts as so many sigma off."""
STATED = 10.0
"""The noise set's word on the boxes' noise counts as much as so many residuals."""
PROBES = 12
HASTE = 1.5
"""The fixed point is approached by small steps in one direction: longer ones get there sooner."""
LEAST = {FAST: 1e-6, BOX: 0.02}
SPEEDS = (3e-4, 3.0)
PIXELS = (0.2, 500.0)
LONGEST_STEP_S = 0.25
HOLD = 1e12


@dataclass(frozen=True)
class State:
    """Where a descent stands.

    Attributes:
        unknowns: (size,).
        pixel: one sigma of the boxes' white noise, px.
        strengths: (strengths,) see `layout.py`.
        distances: (n,) how many sigma of the noise boxes are off.
        cost: of residuals and unknowns.
        log_likelihood: with the unknowns integrated out.
        factor: of H; None before the first step.
        told: (strengths + 1,) unknowns of each process that the data tell, at last those of the
            receiver's drift.
    """

    unknowns: Array
    pixel: float
    strengths: Array
    distances: Array
    cost: float
    log_likelihood: float = -math.inf
    factor: SuperLU | None = None
    told: Array | None = None


class Evidence:
    """The boxes of some images, linked to robots, and their likelihood.

    Args:
        motion: poses.
        stamps_ns: (m,) of the images.
        boxes: of these images, all with a robot.
        tracks: (n,) robots, from 0 on.
        layout: of the unknowns.
        centres: (robots, 2) that paths are told from, m.
        names: of the robots: class and number.
    """

    def __init__(
        self,
        motion: Motion,
        stamps_ns: Stamps,
        boxes: Boxes,
        tracks: NDArray[np.intp],
        layout: Layout,
        centres: Array,
        names: tuple[str, ...],
    ) -> None:
        self._motion, self.stamps_ns, self.boxes = motion, stamps_ns, boxes
        self.tracks, self.layout, self.centres = tracks, layout, centres
        self.names = names
        self._path_columns, self._path_weights = self._spread_paths()
        self._box_columns, self._box_weights = self._spread_boxes()
        self._columns = self._all_columns()
        self._signs = np.random.default_rng(1)

    def places(self, unknowns: Array) -> Array:
        """Return where the robots are at each box, (n, 2) m."""
        found = unknowns[self._path_columns]
        along: Array = np.einsum("nak,nk->na", found, self._path_weights)
        return self.centres[self.tracks] + along

    def poses(self, unknowns: Array) -> Poses:
        """Return the images' poses as telemetry has them."""
        return self._motion.at(self.stamps_ns, float(unknowns[LATENCY]), float(unknowns[EXTRA]))

    def predicted(self, unknowns: Array) -> Predicted:
        """Return what the model says; lasting errors of boxes are part of it."""
        layout, poses = self.layout, self.poses(unknowns)
        found = predicted(
            self.boxes, poses, self._errors(unknowns), self.places(unknowns),
            float(unknowns[FOCAL]),
        )  # fmt: skip
        lasting = np.einsum("nak,nk->na", unknowns[self._box_columns], self._box_weights)
        assert layout.size == len(unknowns)  # noqa: S101
        return replace(found, values=found.values - lasting)

    def start(self, unknowns: Array, pixel: float, strengths: Array) -> State:
        """Return the state before the first step."""
        state = State(unknowns, pixel, strengths, np.zeros(0), math.inf)
        return self._paid(state, self.predicted(unknowns), self.layout.precision(strengths)[0])

    def descend(self, state: State, steps: int, held: frozenset[int], adapt: bool = True) -> State:
        """Return the state after so many Gauss-Newton steps.

        Args:
            state: to begin at.
            steps: most of them.
            held: constants that keep their value.
            adapt: find noise and strengths, too.
        """
        for _ in range(steps):
            before = state
            state = self._step(state, held)
            if adapt:
                state = self._adapted(state)
            moved = abs(state.log_likelihood - before.log_likelihood)
            if not adapt and moved < 0.02:
                break
        return self.evaluated(state, held)

    def evaluated(self, state: State, held: frozenset[int]) -> State:
        """Return the state with its likelihood, noise and strengths being as they are."""
        found = self.predicted(state.unknowns)
        prior, log_det = self.layout.precision(state.strengths)
        state = self._paid(state, found, prior)
        information, _ = self._normal(state, found, prior, held)
        factor = _factor(information)
        whole = float(np.sum(np.log(np.abs(factor.U.diagonal()))))
        # What is held is no unknown: its entry of H cancels, and its precision does not count.
        log_det += sum(math.log(HOLD * BEFORE[one] ** 2) for one in held)
        boxes = 2.0 * len(self.tracks) * math.log(state.pixel * math.sqrt(2.0 * math.pi))
        volume = 2.0 * float(self._shares(state) @ found.area)  # is in the determinant already
        value = -0.5 * (state.cost - volume + whole - log_det) - boxes
        return replace(state, log_likelihood=value, factor=factor)

    def covariance(self, state: State, picks: Array) -> Array:
        """Return the covariance of some linear functions (k, size) of the unknowns."""
        assert state.factor is not None  # noqa: S101
        return np.asarray(picks @ state.factor.solve(np.ascontiguousarray(picks.T)))

    def slopes(self, state: State, picks: Array, wanted: list[int], held: frozenset[int]) -> Array:
        """Return how linear functions (k, size) of the best fit move with held constants (k, m)."""
        assert state.factor is not None  # noqa: S101
        found = self.predicted(state.unknowns)
        prior, _ = self.layout.precision(state.strengths)
        open_, _ = self._normal(state, found, prior, frozenset())
        pull = -np.asarray(open_[:, wanted].todense())
        pull[list(held)] = 0.0
        return np.asarray(picks @ state.factor.solve(np.ascontiguousarray(pull)))

    def _step(self, state: State, held: frozenset[int]) -> State:
        found = self.predicted(state.unknowns)
        prior, _ = self.layout.precision(state.strengths)
        state = self._paid(state, found, prior)
        information, gradient = self._normal(state, found, prior, held)
        factor = _factor(information)
        step = factor.solve(gradient)
        far = max(abs(float(step[LATENCY])), abs(float(step[EXTRA])), 1e-9)
        share = min(1.0, LONGEST_STEP_S / far)
        for _ in range(4):
            tried = self._moved(state, state.unknowns + share * step, prior)
            if tried.cost > state.cost:
                tried = self._along(tried, prior)
            if tried.cost <= state.cost * (1.0 + 1e-6):
                return replace(tried, factor=factor)
            share *= 0.3
        return replace(state, factor=factor)

    def _along(self, state: State, prior: csc_matrix) -> State:
        """Return the state with all but the constants solved for again.

        A step in height or roll is a large one for the robots' places: what is left of it beyond
        the straight line is theirs to follow.
        """
        found = self.predicted(state.unknowns)
        information, gradient = self._normal(state, found, prior, frozenset(range(GLOBALS)))
        return self._moved(state, state.unknowns + _factor(information).solve(gradient), prior)

    def _moved(self, state: State, unknowns: Array, prior: csc_matrix) -> State:
        return self._paid(replace(state, unknowns=unknowns), self.predicted(unknowns), prior)

    def _adapted(self, state: State) -> State:
        """Return the state with strengths and noise by one turn of the fixed point."""
        assert state.factor is not None  # noqa: S101
        layout, x = self.layout, state.unknowns
        strengths, told = state.strengths.copy(), np.zeros(layout.strengths)
        open_, drifts = self._open(state.factor, strengths)
        for strength in range(layout.strengths):
            columns, part = layout.part(strength)
            rank = len(columns) - (2 if strength >= FIRST_ROBOT else 0)
            told[strength] = max(rank - open_[strength], 0.02 * rank**0.5)
            size = max(float(x @ (part @ x)), 0.0)  # rounding may make it less
            ratio = math.sqrt(size / told[strength]) / strengths[strength]
            found = strengths[strength] * float(np.clip(ratio**HASTE, 0.2, 5.0))
            low, high = SPEEDS if strength >= FIRST_ROBOT else (LEAST[strength], math.inf)
            strengths[strength] = min(max(found, low), high)
        weights = _weights(state.distances)
        left = 2.0 * len(self.tracks) - float(np.sum(told)) - sum(drifts)
        left -= len(CONSTANTS) + 2.0 * len(layout.paths)
        residual = float(np.sum(weights * np.square(state.distances))) * state.pixel**2
        residual += STATED * layout.pixel**2
        pixel = math.sqrt(residual / (max(left, 0.0) + STATED))
        pixel = min(max(pixel, PIXELS[0]), PIXELS[1])
        told = np.append(told, drifts[0])
        return replace(state, strengths=strengths, pixel=pixel, told=told)

    def _open(self, factor: SuperLU, strengths: Array) -> tuple[Array, tuple[float, float]]:
        """Return how many unknowns of each process the data leave open, and those that they tell.

        The latter of the receiver's drift and of the other drifts. Traces of a process's precision
        times the covariance, by random signs (Hutchinson 1990).
        """
        kinds = [*range(len(strengths)), DRIFT]
        signs = np.zeros((self.layout.size, PROBES * len(kinds)))
        parts = [self.layout.part(kind) for kind in kinds]
        for number, (columns, _) in enumerate(parts):
            probes = self._signs.choice((-1.0, 1.0), (len(columns), PROBES))
            signs[columns, number * PROBES : (number + 1) * PROBES] = probes
        solved = factor.solve(signs)
        rows = []
        for number, (columns, part) in enumerate(parts):
            own = slice(number * PROBES, (number + 1) * PROBES)
            rows.append(np.sum(signs[columns, own] * (part @ solved[:, own])[columns], axis=1))
        found = np.array([float(row.sum()) / PROBES for row in rows[:-1]]) / np.square(strengths)
        told = 1.0 - rows[-1] / PROBES
        level = self.layout.first_slow[2] - self.layout.first_slow[0]
        return found, (max(float(told[:level].sum()), 0.0), max(float(told[level:].sum()), 0.0))

    def _paid(self, state: State, found: Predicted, prior: csc_matrix) -> State:
        """Return the state with distances and cost of what the model says."""
        off = np.linalg.norm(found.values, axis=1) / state.pixel
        distances = np.where(np.isfinite(off), off, LOST)
        inner = np.minimum(distances, HUBER)
        robust = float(np.sum(inner * (2.0 * distances - inner)))
        x = state.unknowns
        volume = 2.0 * float(self._shares(state) @ found.area)
        return replace(state, distances=distances, cost=robust + volume + float(x @ (prior @ x)))

    def _shares(self, state: State) -> Array:
        """Return how many unknowns in metres each box tells, halved, (n,)."""
        if state.told is None:
            return np.zeros(len(self.tracks))
        counts = np.bincount(self.tracks)
        share: Array = 0.5 * state.told[FIRST_ROBOT:-1][self.tracks] / counts[self.tracks]
        return share + 0.5 * float(state.told[-1]) / len(self.tracks)

    def _by_errors(self, force: Array) -> Array:
        """Return the gradient (size,) of forces (n, 6) on the pose's errors at each box."""
        layout, gradient = self.layout, np.zeros(self.layout.size)
        for number, name in enumerate(ERRORS):
            own = force[:, number, None]
            hats, first = layout.slow[number], layout.first_slow[number]
            np.add.at(gradient, first + hats.columns, own * hats.weights)
            if name in CONSTANTS:
                gradient[FIRST_ERROR + CONSTANTS.index(name)] += float(np.sum(own))
        for axis in range(3):
            first = layout.first_fast + axis * layout.fast.count
            own = force[:, 3 + axis, None]
            np.add.at(gradient, first + layout.fast.columns, own * layout.pointing[axis])
        return gradient

    def _normal(
        self, state: State, found: Predicted, prior: csc_matrix, held: frozenset[int]
    ) -> tuple[csc_matrix, Array]:
        """Return the information on the unknowns and the gradient."""
        values = np.nan_to_num(found.values)
        seen = np.isfinite(found.values).all(axis=1)
        weight = np.sqrt(_weights(state.distances) * seen) / state.pixel
        entries = self._jacobian(found) * weight[:, None, None]
        count, _, width = entries.shape
        indices = np.repeat(self._columns, 1, axis=0).reshape(2 * count, width)
        jacobian = csr_matrix(
            (entries.reshape(-1), indices.reshape(-1), np.arange(0, 2 * count * width + 1, width)),
            shape=(2 * count, self.layout.size),
        )
        firm = np.zeros(self.layout.size)
        firm[list(held)] = HOLD
        information = csc_matrix(jacobian.T @ jacobian) + prior + diags(firm, format="csc")
        gradient = jacobian.T @ (values * weight[:, None]).ravel() - prior @ state.unknowns
        gradient -= self._by_errors(self._shares(state)[:, None] * found.area_by_error)
        return information, np.asarray(gradient)

    def _errors(self, unknowns: Array) -> Array:
        """Return the pose's errors (n, 6) at each box."""
        layout, at = self.layout, self.boxes.images
        errors = np.zeros((len(self.tracks), len(ERRORS)))
        for number, name in enumerate(ERRORS):
            hats, first = layout.slow[number], layout.first_slow[number]
            drift = unknowns[first + hats.columns] * hats.weights
            errors[:, number] = drift.sum(axis=1)
            if name in CONSTANTS:
                errors[:, number] += unknowns[FIRST_ERROR + CONSTANTS.index(name)]
        for axis in range(3):
            first = layout.first_fast + axis * layout.fast.count
            pointing = unknowns[first + layout.fast.columns] * layout.pointing[axis]
            errors[:, 3 + axis] += pointing.sum(axis=1)
        assert len(at) == len(errors)  # noqa: S101
        return errors

    def _spread_paths(self) -> tuple[NDArray[np.intp], Array]:
        columns = np.zeros((len(self.tracks), 2, 4), dtype=np.intp)
        weights = np.zeros((len(self.tracks), 4))
        for first, path in zip(self.layout.first_path, self.layout.paths, strict=True):
            for axis in range(2):
                columns[path.rows, axis] = first + axis * path.count + path.columns
            weights[path.rows] = path.weights
        return columns, weights

    def _spread_boxes(self) -> tuple[NDArray[np.intp], Array]:
        columns = np.zeros((len(self.tracks), 2, 2), dtype=np.intp)
        weights = np.zeros((len(self.tracks), 2))
        layout = self.layout
        for first, hats, path in zip(layout.first_box, layout.boxes, layout.paths, strict=True):
            for axis in range(2):
                columns[path.rows, axis] = first + axis * hats.count + hats.columns
            weights[path.rows] = hats.weights
        return columns, weights

    def _all_columns(self) -> NDArray[np.intp]:
        """Return the unknowns (n, 2, width) that each box's u and v depend on."""
        layout, count = self.layout, len(self.tracks)
        constants = np.arange(FIRST_ERROR + len(CONSTANTS))
        parts = [np.broadcast_to(constants, (count, 2, len(constants)))]
        for hats, first in zip(layout.slow, layout.first_slow, strict=True):
            parts.append(_twice(first + hats.columns))
        for axis in range(3):
            first = layout.first_fast + axis * layout.fast.count
            parts.append(_twice(first + layout.fast.columns))
        parts += [_twice(self._path_columns[:, axis]) for axis in range(2)]
        parts.append(self._box_columns)
        return np.concatenate(parts, axis=2)

    def _jacobian(self, found: Predicted) -> Array:
        """Return the derivatives (n, 2, width) by these unknowns."""
        layout = self.layout
        first = [found.by_latency, found.by_extra, found.by_focal]
        parts = [one[:, :, None] for one in first]
        parts.append(found.by_error[:, :, [ERRORS.index(name) for name in CONSTANTS]])
        parts += [
            found.by_error[:, :, k, None] * hats.weights[:, None, :]
            for k, hats in enumerate(layout.slow)
        ]
        parts += [
            found.by_error[:, :, 3 + k, None] * weights[:, None, :]
            for k, weights in enumerate(layout.pointing)
        ]
        path = self._path_weights[:, None, :]
        parts += [found.by_place[:, :, axis, None] * path for axis in range(2)]
        parts.append(np.broadcast_to(self._box_weights[:, None, :], (len(path), 2, 2)))
        return np.nan_to_num(np.concatenate(parts, axis=2))


def _twice(columns: NDArray[np.intp]) -> NDArray[np.intp]:
    return np.broadcast_to(columns[:, None, :], (len(columns), 2, columns.shape[1]))


def _weights(distances: Array) -> Array:
    return np.asarray(np.minimum(1.0, HUBER / np.maximum(distances, 1e-9)))


def _factor(information: csc_matrix) -> SuperLU:
    return splu(
        information, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
