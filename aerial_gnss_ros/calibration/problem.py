# SPDX-License-Identifier: Apache-2.0
"""One recording's least squares: Gauss-Newton with Levenberg's damping, a robust weight, priors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.fit import Fit
from aerial_gnss_ros.calibration.model import (
    FOCAL,
    LATENCY,
    Boxes,
    Layout,
    Residuals,
    residuals,
)
from aerial_gnss_ros.calibration.poses import PoseTable
from aerial_gnss_ros.calibration.priors import Priors
from aerial_gnss_ros.calibration.recording import Recording, thinned
from aerial_gnss_ros.calibration.reduced import HUBER, cost, huber, reduced, whole_distances
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.errors import InputError

Array = NDArray[np.float64]

MOST_IMAGES = 700
COARSE_IMAGES = 120
COARSE_S = np.arange(-3.0, 3.01, 0.5)
ITERATIONS = 15
RIPPLE = 5e-4
"""The cost ripples by about so much with the latency, as noisy samples come and go."""
FAR = 30.0
"""A box that the model does not see at all counts as so many sigma off."""
_MEDIAN_CHI2 = 2.0 * math.log(2.0)


@dataclass(frozen=True)
class _State:
    """Where a descent stands: unknowns, each image's own errors, what boxes say to them."""

    unknowns: Array
    own: Array
    rows: Residuals
    cost: float


class Problem:
    """One recording with its unknowns, priors and weights."""

    def __init__(
        self, recording: Recording, config: EstimatorConfig, names: tuple[str, ...], speed: float
    ) -> None:
        self._config, self._names = config, names
        self._all = recording.sightings
        self._table = PoseTable(recording)
        self._layout = Layout(self._all, still=speed <= 0.0)
        self._first_places = _first_places(recording, self._layout)
        self._priors = Priors(config, self._layout, names, speed)
        self._pixel = max(config.noise.value("box_center_px"), 0.1) ** 2
        self.last = np.zeros(0)

    def search(self, report: Callable[[int], None]) -> Array:
        """Return unknowns at the best latency of the grid."""
        layout = self._layout
        boxes = Boxes.of(thinned(self._all, COARSE_IMAGES), layout)
        best, found = math.inf, self._first_places
        for done, late in enumerate(COARSE_S - self._config.camera.latency_s, start=1):
            start = self._first_places.copy()
            start[LATENCY] = late
            solved = self._descend(boxes, start, frozenset(), 4, True)
            report(done)
            if solved.cost < best:
                best, found = solved.cost, solved.unknowns
        return found

    def fit(self, start: Array, tight: frozenset[str]) -> Fit:
        """Return the fit from a start; constants in `tight` have the noise set's own prior."""
        boxes = Boxes.of(thinned(self._all, MOST_IMAGES), self._layout)
        state = self._descend(boxes, start, tight, ITERATIONS, False)
        self.last = state.unknowns
        rows = state.rows
        if not len(rows.values):
            raise InputError(
                "no image has telemetry round it at any latency within 3 s; record telemetry from "
                "3 s before the images to 3 s after them."
            )
        # Steps took images as independent; what is claimed must not.
        variances = self._priors.own(self._priors.alike(boxes.image_count))
        equations = reduced(rows, state.own, variances, self._pixel)
        covariance = np.linalg.inv(equations.normal + self._priors.information(tight))
        distance = whole_distances(rows, state.own, variances, self._pixel)
        # Residuals larger than the noise says make everything less sure.
        excess = max(1.0, float(np.sqrt(np.median(distance**2) / _MEDIAN_CHI2)))
        pick = self._pick(self._layout)
        residual = float(np.sqrt(np.mean(np.minimum(rows.values**2, 1e4))))
        return Fit(
            self._names, pick @ state.unknowns, excess**2 * pick @ covariance @ pick.T, residual,
            len(rows.values), int(np.sum(distance > HUBER)), len(np.unique(rows.images)),
            self._layout.robots,
        )  # fmt: skip

    def _descend(
        self,
        boxes: Boxes,
        start: Array,
        tight: frozenset[str],
        iterations: int,
        hold_latency: bool,
    ) -> _State:
        """Return where Gauss-Newton steps with Levenberg's damping end."""
        prior, goal = self._priors.information(tight), self._first_places
        variances = self._priors.own()

        def state(unknowns: Array, own: Array) -> _State:
            late = self._config.camera.latency_s
            rows = residuals(self._table, boxes, self._layout, unknowns, own, late)
            lost = (len(boxes.robots) - len(rows.values)) * huber(np.array([FAR]))
            off = goal - unknowns
            paid = cost(rows, own, variances, self._pixel) + float(off @ prior @ off)
            return _State(unknowns, own, rows, lost + paid)

        now, damping = state(start, np.zeros((boxes.image_count, 6))), 1e-6
        for _ in range(iterations):
            if not len(now.rows.values):
                return replace(now, cost=math.inf)
            equations = reduced(now.rows, now.own, variances, self._pixel)
            normal = equations.normal + prior
            if hold_latency:
                normal[LATENCY, LATENCY] += 1e12
            gradient = equations.gradient + prior @ (goal - now.unknowns)
            step = _solved(normal + damping * np.diag(np.diag(normal)), gradient)
            moved = state(now.unknowns + step, now.own + equations.own_step(step))
            if moved.cost <= now.cost * (1.0 + RIPPLE):
                done = now.cost - moved.cost < 1e-4 * now.cost / max(len(boxes.robots), 1)
                now, damping = moved, 0.1 * damping
                if done:
                    break
            else:
                damping = max(100.0 * damping, 1e-6)
                if damping > 1e3:
                    break
        return now

    def _pick(self, layout: Layout) -> Array:
        pick = np.zeros((len(self._names), layout.size))
        for row, name in enumerate(self._names):
            if name == "latency":
                pick[row, LATENCY] = 1.0
            elif name == "focal":
                pick[row, FOCAL] = 1.0
            else:
                pick[row, layout.drift(name)] = 1.0 / layout.knots
        return pick


def _solved(normal: Array, gradient: Array) -> Array:
    """Return the step, shortened where it goes too far in latency."""
    step = np.linalg.solve(normal, gradient)
    share = min(1.0, 0.3 / max(1e-9, abs(float(step[LATENCY]))))
    return np.asarray(share * step, dtype=np.float64)


def _first_places(recording: Recording, layout: Layout) -> Array:
    """Return unknowns without errors, robots where the tracker had them (in the median)."""
    seen: dict[str, list[Array]] = {}
    for sighting in recording.sightings:
        for name, place in zip(sighting.robots, sighting.places, strict=True):
            seen.setdefault(name, []).append(place)
    start = np.zeros(layout.size)
    for number, robot in enumerate(layout.robots):
        start[layout.place(number)] = np.median(seen[robot], axis=0)
    return start
