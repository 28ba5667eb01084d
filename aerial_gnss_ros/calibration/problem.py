# SPDX-License-Identifier: Apache-2.0
"""One recording's least squares: Gauss-Newton with Levenberg's damping, a robust weight, priors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.fit import Fit, unknown
from aerial_gnss_ros.calibration.model import (
    DRIFTING,
    FOCAL,
    LATENCY,
    Boxes,
    Layout,
    Residuals,
    residuals,
)
from aerial_gnss_ros.calibration.poses import PoseTable
from aerial_gnss_ros.calibration.recording import Recording, thinned
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.core.noise import Noise

Array = NDArray[np.float64]

HUBER = 2.5
MOST_IMAGES = 700
COARSE_IMAGES = 120
COARSE_S = np.arange(-3.0, 3.01, 0.5)
ITERATIONS = 15
RIPPLE = 5e-4
"""The cost ripples by about so much with the latency, as noisy samples come and go."""
FOCAL_NOISE = 1.0
"""How well a stated focal length is known that the flight does not tell, %."""
FAR = 30.0
"""A box that the model does not see at all counts as so many sigma off."""


class Problem:
    """One recording with its unknowns, priors and weights."""

    def __init__(
        self, recording: Recording, config: EstimatorConfig, names: tuple[str, ...], speed: float
    ) -> None:
        self._config, self._names, self._speed = config, names, speed
        self._all = recording.sightings
        self._table = PoseTable(recording)
        self._layout = Layout(self._all, still=speed <= 0.0)
        self._first_places = _first_places(recording, self._layout)
        self._focal = float(self._all[0].camera.K[0, 0])
        self._white = self._pose_noise()
        self.last = np.zeros(0)

    def search(self, report: Callable[[int], None]) -> Array:
        """Return unknowns at the best latency of the grid."""
        layout = self._layout
        boxes = Boxes.of(thinned(self._all, COARSE_IMAGES), layout)
        best, found = math.inf, self._first_places
        for done, late in enumerate(COARSE_S - self._config.camera.latency_s, start=1):
            start = self._first_places.copy()
            start[LATENCY] = late
            solved, cost = self._descend(boxes, start, frozenset(), 4, True)
            report(done)
            if cost < best:
                best, found = cost, solved
        return found

    def fit(self, start: Array, tight: frozenset[str]) -> Fit:
        """Return the fit from a start; constants in `tight` have the noise set's own prior."""
        layout = self._layout
        boxes = Boxes.of(thinned(self._all, MOST_IMAGES), layout)
        solved, _ = self._descend(boxes, start, tight, ITERATIONS, False)
        self.last = solved
        rows = self._residuals(boxes, solved)
        if not len(rows.values):
            raise InputError(
                "no image has telemetry round it at any latency within 3 s; record telemetry from "
                "3 s before the images to 3 s after them."
            )
        _, distance = self._weights(rows)
        nothing = np.zeros(layout.size)
        normal, _ = self._normal(rows, self._prior(tight), nothing)
        covariance = np.linalg.inv(normal)
        # Residuals larger than the noise says make everything less sure.
        excess = max(1.0, float(np.sqrt(np.median(distance**2) / _MEDIAN_CHI2)))
        pick = self._pick(layout)
        residual = float(np.sqrt(np.mean(np.minimum(rows.values**2, 1e4))))
        return Fit(
            self._names, pick @ solved, excess**2 * pick @ covariance @ pick.T, residual,
            len(rows.values), int(np.sum(distance > HUBER)), len(np.unique(rows.stamps_ns)),
            layout.robots,
        )  # fmt: skip

    def _residuals(self, boxes: Boxes, unknowns: Array) -> Residuals:
        late = self._config.camera.latency_s
        return residuals(self._table, boxes, self._layout, unknowns, late)

    def _descend(
        self,
        boxes: Boxes,
        start: Array,
        tight: frozenset[str],
        iterations: int,
        hold_latency: bool,
    ) -> tuple[Array, float]:
        """Return the unknowns after Gauss-Newton steps (Levenberg's damping), and the cost."""
        total = len(boxes.robots)
        prior, goal = self._prior(tight), self._first_places

        def cost(rows: Residuals, now: Array) -> float:
            lost = (total - len(rows.values)) * _huber(np.array([FAR]))
            return (
                lost + _huber(self._weights(rows)[1]) + float((goal - now) @ prior @ (goal - now))
            )

        now, damping = start, 1e-6
        rows = self._residuals(boxes, now)
        least = cost(rows, now)
        for _ in range(iterations):
            if not len(rows.values):
                return now, math.inf
            normal, gradient = self._normal(rows, prior, goal - now)
            if hold_latency:
                normal[LATENCY, LATENCY] += 1e12
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), gradient)
            step *= min(1.0, 0.3 / max(1e-9, abs(float(step[LATENCY]))))
            moved = self._residuals(boxes, now + step)
            reached = cost(moved, now + step)
            if reached <= least * (1.0 + RIPPLE):
                done = least - reached < 1e-4 * least / max(total, 1)
                now, rows, least, damping = now + step, moved, reached, 0.1 * damping
                if done:
                    break
            else:
                damping = max(100.0 * damping, 1e-6)
                if damping > 1e3:
                    break
        return now, least

    def _weights(self, rows: Residuals) -> tuple[Array, Array]:
        """Return the boxes' weights (n,), 1/px², and normalised distances (n,)."""
        focal = self._focal
        angle2, place2 = self._white
        sigma2: Array = np.full(len(rows.values), focal**2 * angle2)
        sigma2 += self._config.noise.value("box_center_px") ** 2
        sigma2 = sigma2 + focal**2 * place2 / np.maximum(rows.ranges, 1.0) ** 2
        distance = np.sqrt(np.sum(rows.values**2, axis=1) / sigma2)
        return np.minimum(1.0, HUBER / np.maximum(distance, 1e-9)) / sigma2, distance

    def _pose_noise(self) -> tuple[float, float]:
        """Return the variances of the pose that count as white: angle (rad²), place (m²).

        Between knots drifts are bridges, with a mean variance of 1/6 of the step's; all images
        of half a step have nearly the same one, so it counts as often.
        """
        noise, layout = self._config.noise, self._layout
        rate = len(self._all) / max(layout.step_s * (layout.knots - 1), 1e-3)
        alike = max(1.0, 0.5 * layout.step_s * min(rate, MOST_IMAGES / len(self._all) * rate))
        share = alike / 6.0 * 2.0 * layout.step_s / max(noise.value("correlation_time_s"), 1e-3)

        def variance(white: str, slow: str) -> float:
            return float(noise.value(white) ** 2 + share * noise.value(slow) ** 2)

        angle = variance("gimbal_white_deg", "gimbal_pitch_deg")
        angle += variance("attitude_white_deg", "heading_deg")
        place = variance("gnss_white_m", "gnss_offset_m") + variance("height_white_m", "height_m")
        return angle * math.radians(1.0) ** 2, place

    def _normal(self, rows: Residuals, prior: Array, off: Array) -> tuple[Array, Array]:
        """Return information matrix and gradient; `off` is how far the priors' goal is."""
        weight, _ = self._weights(rows)
        flat = rows.jacobian.reshape(-1, self._layout.size)
        weighted = flat * np.repeat(weight, 2)[:, None]
        normal, gradient = weighted.T @ flat, weighted.T @ rows.values.ravel()
        return normal + prior, gradient + prior @ off

    def _prior(self, tight: frozenset[str]) -> Array:
        layout = self._layout
        noise: Noise = self._config.noise
        prior = np.zeros((layout.size, layout.size))
        scale = unknown("focal").scale
        focal = unknown("focal").prior if "focal" in self._names else 1e-3
        if "focal" in tight:
            focal = FOCAL_NOISE
        prior[LATENCY, LATENCY] = _information(unknown("latency").prior)
        prior[FOCAL, FOCAL] = _information(focal / scale)
        drift = math.sqrt(2.0 * layout.step_s / max(noise.value("correlation_time_s"), 1e-3))
        for name in DRIFTING:
            columns = layout.drift(name)
            angle = not name.startswith(("gnss", "height"))
            key = {"gnss_east": "gnss_offset_m", "gnss_north": "gnss_offset_m",
                   "height": "height_m"}.get(name, f"{name}_deg")  # fmt: skip
            own = noise.value(key) * (math.radians(1.0) if angle else 1.0)
            if name.startswith("gnss"):
                first = 1e-3  # a constant offset moves robots and drone alike
            elif name in tight:
                first = max(own, 1e-6)
            else:
                first = unknown(name).prior / unknown(name).scale
            mean = np.zeros(layout.size)
            mean[columns] = 1.0 / len(columns)
            prior += _information(first) * np.outer(mean, mean)
            _walk(prior, columns, max(own * drift, 1e-9))
        roam = max(self._speed * layout.robot_step_s, 1e-3)
        for robot in range(len(layout.robots)):
            for axis in range(2):
                columns = layout.place(robot)[:, axis]
                prior[columns, columns] += _information(100.0)
                _walk(prior, columns, roam)
        return prior

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


_MEDIAN_CHI2 = 2.0 * math.log(2.0)


def _information(sigma: float) -> float:
    return 1.0 / sigma**2


def _walk(prior: Array, columns: NDArray[np.intp], sigma: float) -> None:
    """Let neighbouring knots differ by so much."""
    information = _information(sigma)
    for a, b in itertools.pairwise(columns):
        prior[a, a] += information
        prior[b, b] += information
        prior[a, b] -= information
        prior[b, a] -= information


def _huber(distance: Array) -> float:
    """Huber's cost of normalised distances."""
    inner = np.minimum(distance, HUBER)
    return float(np.sum(inner * (2.0 * distance - inner)))
