# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The unknowns of a recording, where each stands, and what is known of them before the boxes.

Constants: latency, extra delay of fixes, logarithm of the focal scale, errors of height, roll,
pitch and heading. Functions of time, all Gaussian processes on knots: what platform errors drift by
(Gauss-Markov as the noise set says), errors of the camera's pointing between two samples of
telemetry (Gauss-Markov over 0.7 s), each robot's path (a cubic spline; its velocity is an
Ornstein-Uhlenbeck process, so that a robot that stays is one whose speed is 0), and errors of a
robot's boxes that last for seconds. How strong the last three are is found from the data
(`evidence.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csc_matrix

from aerial_gnss_ros.calibration.motion import ERRORS
from aerial_gnss_ros.core.config.noise import Noise

Array = NDArray[np.float64]
Index = NDArray[np.intp]

LATENCY, EXTRA, FOCAL, FIRST_ERROR = 0, 1, 2, 3
CONSTANTS = ("height", "gimbal_roll", "gimbal_pitch", "heading")
GLOBALS = FIRST_ERROR + len(CONSTANTS)
BEFORE = (100.0, 0.5, 0.05, 5.0, math.radians(5.0), math.radians(5.0), math.radians(20.0))
"""One sigma of the constants before the data: s, s, 1, m, rad, rad, rad."""
PATH_KNOT_S, BOX_KNOT_S = 1.0, 1.5
MOST_SLOW, MOST_PATH, MOST_BOX = 400, 150, 80
VELOCITY_TIME_S = 8.0
"""Robots keep their velocity for about so long."""
POINTING_TIME_S = 0.7
"""What telemetry does not tell of a camera's shaking, or smoothing takes away, stays so long."""
BOX_TIME_S = 2.0
"""What is wrong with a robot's boxes stays for about so long: the hull turns in the view."""
ANYWHERE_M = 300.0
FAST, BOX, FIRST_ROBOT, DRIFT, FIXED = 0, 1, 2, -2, -1
"""Numbers of the strengths: of pointing, of boxes, of the robots from then on."""
_NOISE_KEYS = {
    "gnss_east": "gnss_offset_m",
    "gnss_north": "gnss_offset_m",
    "height": "height_m",
    "gimbal_roll": "gimbal_roll_deg",
    "gimbal_pitch": "gimbal_pitch_deg",
    "heading": "heading_deg",
}


@dataclass(frozen=True)
class Hats:
    """Piecewise linear functions on even knots, for each of n times.

    Attributes:
        columns: (n, 2) knots.
        weights: (n, 2) how much they count.
        count: of knots.
        step_s: between them.
    """

    columns: Index
    weights: Array
    count: int
    step_s: float

    @staticmethod
    def of(t: Array, step_s: float, most: int) -> Hats:
        """Return those over the span of the times."""
        first, span = float(t.min()), max(float(np.ptp(t)), 1e-3)
        count = int(np.clip(math.ceil(span / step_s - 1e-6) + 1, 2, most))
        at = (t - first) / span * (count - 1)
        low = np.clip(at.astype(np.intp), 0, count - 2)
        share = at - low
        return Hats(
            np.stack([low, low + 1], axis=1), np.stack([1.0 - share, share], axis=1), count,
            span / (count - 1),
        )  # fmt: skip

    def table(self) -> Array:
        """Return (n, count) weights."""
        full = np.zeros((len(self.columns), self.count))
        np.put_along_axis(full, self.columns, self.weights, axis=1)
        return full


@dataclass(frozen=True)
class Path:
    """One robot's path, a cubic spline.

    Attributes:
        rows: boxes of the robot.
        columns: (k, 4) coefficients that count at each box, from 0.
        weights: (k, 4).
        count: of coefficients for one axis.
        rough: (count, count) precision where the speed's one sigma is 1 m/s.
        middle: (count,) how much coefficients count in the middle of the path.
        log_det: of the precision of one axis at 1 m/s.
    """

    rows: Index
    columns: Index
    weights: Array
    count: int
    rough: Array
    middle: Array
    log_det: float

    @staticmethod
    def of(t: Array, rows: Index, knot_s: float = PATH_KNOT_S) -> Path:
        """Return the path of the robot with these boxes."""
        own = t[rows]
        first, span = float(own.min()), max(float(np.ptp(own)), 0.5)
        pieces = int(np.clip(round(span / knot_s), 1, MOST_PATH))
        knots = np.concatenate([[first] * 3, np.linspace(first, first + span, pieces + 1)])
        knots = np.concatenate([knots, [first + span] * 3])
        count = pieces + 3
        basis = BSpline(knots, np.eye(count), 3)
        low = np.clip(((own - first) / span * pieces).astype(np.intp), 0, pieces - 1)
        columns = low[:, None] + np.arange(4)
        weights = np.take_along_axis(basis(np.clip(own, first, first + span)), columns, axis=1)
        nodes, share = np.polynomial.legendre.leggauss(4)
        length = span / pieces
        fine = first + length * (np.arange(pieces)[:, None] + 0.5 * (nodes + 1.0)).ravel()
        velocity, acceleration = basis.derivative(), basis.derivative(2)
        pull = acceleration(fine) + velocity(fine) / VELOCITY_TIME_S
        weight = np.tile(0.5 * length * share, pieces)
        rough = 0.5 * VELOCITY_TIME_S * (pull.T * weight) @ pull
        begin = velocity(np.array([first]))[0]
        rough += np.outer(begin, begin)
        middle = basis(np.array([first + 0.5 * span]))[0]
        whole = rough + np.outer(middle, middle) / ANYWHERE_M**2
        log_det = float(np.linalg.slogdet(whole)[1])
        return Path(rows, columns, weights, count, rough, middle, log_det)


class Layout:
    """Where each unknown stands, and the precision of all before the data.

    Args:
        t: (n,) times of the boxes, s.
        tracks: (n,) robots, all from 0 on.
        noise: the noise set.
        fast_s: pointing errors so far apart are independent of one another.
        calm_s: what an error does within so long is no part of the poses, by its name.
        pointing: (n, 3) how many times their strength pointing errors are at each box.

    Attributes:
        slow, fast: knots of the drifts and of the pointing.
        pointing: weights of the latter about each axis.
        paths: of the robots.
        boxes: knots of the errors of each robot's boxes.
        size: number of unknowns.
    """

    def __init__(
        self,
        t: Array,
        tracks: Index,
        noise: Noise,
        fast_s: float,
        calm_s: dict[str, float],
        pointing: Array,
    ) -> None:
        self.slow = [Hats.of(t, max(calm_s[name], fast_s), MOST_SLOW) for name in ERRORS]
        self.fast = Hats.of(t, fast_s, len(np.unique(t)) + 1)
        self.pointing = [one[:, None] * self.fast.weights for one in pointing.T]
        rows = [np.flatnonzero(tracks == robot) for robot in range(int(tracks.max()) + 1)]
        self.paths = [Path.of(t, own, max(PATH_KNOT_S, 1.5 * fast_s)) for own in rows]
        self.boxes = [Hats.of(t[own], BOX_KNOT_S, MOST_BOX) for own in rows]
        self._noise = noise
        counts = [hats.count for hats in self.slow]
        self.first_slow = [GLOBALS + sum(counts[:number]) for number in range(len(ERRORS))]
        self.first_fast = GLOBALS + sum(counts)
        at = self.first_fast + 3 * self.fast.count
        self.first_path, self.first_box = [], []
        for path in self.paths:
            self.first_path.append(at)
            at += 2 * path.count
        for hats in self.boxes:
            self.first_box.append(at)
            at += 2 * hats.count
        self.size = at
        self._prior = _Prior(self)
        self._parts: dict[int, tuple[Index, csc_matrix]] = {}

    @property
    def strengths(self) -> int:
        """How many strengths there are."""
        return FIRST_ROBOT + len(self.paths)

    def slow_sigma(self, name: str) -> float:
        """Return one sigma of a drifting error, m or rad."""
        key = _NOISE_KEYS[name]
        return self._noise.value(key) * (math.radians(1.0) if key.endswith("_deg") else 1.0)

    @property
    def pixel(self) -> float:
        """One sigma of a box's centre by the noise set, px."""
        return max(self._noise.value("box_center_px"), 0.1)

    @property
    def correlation_s(self) -> float:
        """Correlation time of the drifting errors."""
        return max(self._noise.value("correlation_time_s"), 1e-3)

    def precision(self, strengths: Array) -> tuple[csc_matrix, float]:
        """Return the precision (size, size) before the data and its logarithmic determinant.

        Args:
            strengths: (strengths,) one sigma: rad, px, m/s a robot.
        """
        return self._prior.at(strengths)

    def part(self, strength: int) -> tuple[Index, csc_matrix]:
        """Return the columns that a strength is that of, and their precision at strength 1."""
        if strength not in self._parts:
            drifts = strength == DRIFT
            own = np.arange(GLOBALS, self.first_fast) if drifts else self._prior.columns[strength]
            self._parts[strength] = own, self._prior.part(strength)
        return self._parts[strength]

    def mean_of(self, name: str) -> Array:
        """Return (size,): what an error's mean over the recording is made of."""
        pick = np.zeros(self.size)
        pick[FIRST_ERROR + CONSTANTS.index(name)] = 1.0
        hats, first = self.slow[ERRORS.index(name)], self.first_slow[ERRORS.index(name)]
        pick[first : first + hats.count] = hats.table().mean(axis=0)
        return pick


class _Prior:
    """The precision as entries of a sparse matrix: fixed ones and those of each strength."""

    def __init__(self, layout: Layout) -> None:
        self._size = layout.size
        self._entries: list[tuple[Index, Index, Array, Index]] = []
        self._ranks = np.zeros(layout.strengths)
        self._log_det = 0.0
        self.columns: list[Index] = [np.zeros(0, dtype=np.intp)] * layout.strengths
        self._drifts(layout)
        fast = np.arange(layout.first_fast, layout.first_fast + 3 * layout.fast.count)
        chain, log_det = _markov(layout.fast, max(POINTING_TIME_S, layout.fast.step_s))
        for axis in range(3):
            self._dense(fast[axis * layout.fast.count :][: layout.fast.count], chain, FAST)
            self._log_det += log_det
        self._ranks[FAST], self.columns[FAST] = len(fast), fast
        self._boxes(layout)
        self._paths(layout)
        parts = list(zip(*self._entries, strict=True))
        self._rows, self._columns, self._values, self._kinds = map(np.concatenate, parts)

    def at(self, strengths: Array) -> tuple[csc_matrix, float]:
        scale = np.append(1.0 / np.square(strengths), [1.0, 1.0])
        constants = 1.0 / np.square(BEFORE)
        first = np.arange(GLOBALS)
        values = np.concatenate([self._values * scale[self._kinds], constants])
        rows, columns = (np.concatenate([one, first]) for one in (self._rows, self._columns))
        matrix = csc_matrix((values, (rows, columns)), shape=(self._size, self._size))
        log_det = float(np.sum(np.log(constants)))
        return matrix, log_det + self._log_det - 2.0 * float(self._ranks @ np.log(strengths))

    def part(self, strength: int) -> csc_matrix:
        """Return the part of the precision that a strength of 1 makes."""
        own = self._kinds == strength
        entries = self._values[own], (self._rows[own], self._columns[own])
        return csc_matrix(entries, shape=(self._size, self._size))

    def _drifts(self, layout: Layout) -> None:
        for name, hats, first in zip(ERRORS, layout.slow, layout.first_slow, strict=True):
            chain, log_det = _markov(hats, layout.correlation_s)
            sigma = max(layout.slow_sigma(name), 1e-6)
            self._dense(np.arange(first, first + hats.count), chain / sigma**2, DRIFT)
            self._log_det += log_det - 2.0 * hats.count * math.log(sigma)

    def _boxes(self, layout: Layout) -> None:
        columns: list[Index] = []
        for first, hats in zip(layout.first_box, layout.boxes, strict=True):
            chain, log_det = _markov(hats, BOX_TIME_S)
            for axis in range(2):
                columns.append(np.arange(hats.count) + first + axis * hats.count)
                self._dense(columns[-1], chain, BOX)
                self._log_det += log_det
            self._ranks[BOX] += 2 * hats.count
        self.columns[BOX] = np.concatenate(columns)

    def _paths(self, layout: Layout) -> None:
        paths = zip(layout.first_path, layout.paths, strict=True)
        for robot, (first, path) in enumerate(paths, start=FIRST_ROBOT):
            for axis in range(2):
                own = np.arange(path.count) + first + axis * path.count
                self._dense(own, path.rough, robot)
                self._dense(own, np.outer(path.middle, path.middle) / ANYWHERE_M**2, FIXED)
            self._ranks[robot] = 2 * (path.count - 1)
            self._log_det += 2.0 * path.log_det
            self.columns[robot] = np.arange(first, first + 2 * path.count)

    def _dense(self, columns: Index, block: Array, kind: int) -> None:
        at = np.nonzero(block)
        self._add(columns[at[0]], columns[at[1]], block[at], kind)

    def _add(self, rows: Index, columns: Index, values: Array, kind: int) -> None:
        self._entries.append((rows, columns, values, np.full(len(rows), kind)))


def _markov(hats: Hats, time_s: float) -> tuple[Array, float]:
    """Return the precision of a Gauss-Markov process of sigma 1 at knots, and its determinant."""
    keep = math.exp(-hats.step_s / time_s)
    fresh = 1.0 - keep * keep
    chain = np.diag(np.full(hats.count, 1.0 + keep * keep))
    chain[0, 0] = chain[-1, -1] = 1.0
    chain -= keep * (np.eye(hats.count, k=1) + np.eye(hats.count, k=-1))
    return chain / fresh, -(hats.count - 1) * math.log(fresh)
