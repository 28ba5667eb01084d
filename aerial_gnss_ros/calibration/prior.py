# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Prior precision of all unknowns, as a sparse matrix.

Its entries are multiplied by 1 / sigma² of their process, so a change of sigmas needs no new
assembly.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from aerial_gnss_ros.calibration.layout import Layout
from aerial_gnss_ros.calibration.pose_errors import ERRORS
from aerial_gnss_ros.calibration.processes import ANYWHERE_M, gauss_markov
from aerial_gnss_ros.calibration.unknowns import (
    BOX,
    DRIFT,
    FIRST_ROBOT,
    FIXED,
    GLOBALS,
    POINTING,
    PRIOR_SIGMAS,
)
from aerial_gnss_ros.core.config.noise import Noise

Array = NDArray[np.float64]
Index = NDArray[np.intp]

POINTING_TIME_S = 0.7
"""Correlation time of pointing errors, s: vibration between samples, and smoothed-out motion."""
BOX_TIME_S = 2.0
"""Correlation time of the errors of a robot's boxes, s: its hull turns in the image."""
_NOISE_KEYS = {
    "gnss_east": "gnss_offset_m",
    "gnss_north": "gnss_offset_m",
    "height": "height_m",
    "gimbal_roll": "gimbal_roll_deg",
    "gimbal_pitch": "gimbal_pitch_deg",
    "heading": "heading_deg",
}


class Prior:
    """The prior precision for any sigmas of the processes.

    Args:
        layout: of the unknowns.
        noise: the noise set.
    """

    def __init__(self, layout: Layout, noise: Noise) -> None:
        self._size, self._noise = layout.size, noise
        self._entries: list[tuple[Index, Index, Array, Index]] = []
        self._ranks = np.zeros(layout.processes)
        self._log_det = 0.0
        self._of_process: list[Index] = [np.zeros(0, dtype=np.intp)] * layout.processes
        self._drift_columns = np.arange(GLOBALS, layout.first_pointing)
        self._add_drifts(layout)
        self._add_pointing(layout)
        self._add_boxes(layout)
        self._add_paths(layout)
        parts = list(zip(*self._entries, strict=True))
        self._rows, self._columns, self._values, self._processes = map(np.concatenate, parts)
        self._parts: dict[int, tuple[Index, csc_matrix]] = {}

    @property
    def pixel(self) -> float:
        """One sigma of a box's centre by the noise set, px."""
        return max(self._noise.value("box_center_px"), 0.1)

    def precision(self, sigmas: Array) -> tuple[csc_matrix, float]:
        """Return the precision (size, size) and its logarithmic determinant.

        Args:
            sigmas: (processes,) rad, px, and m/s for each robot.
        """
        scale = np.append(1.0 / np.square(sigmas), [1.0, 1.0])
        constants = 1.0 / np.square(PRIOR_SIGMAS)
        first = np.arange(GLOBALS)
        values = np.concatenate([self._values * scale[self._processes], constants])
        rows, columns = (np.concatenate([one, first]) for one in (self._rows, self._columns))
        matrix = csc_matrix((values, (rows, columns)), shape=(self._size, self._size))
        log_det = float(np.sum(np.log(constants)))
        return matrix, log_det + self._log_det - 2.0 * float(self._ranks @ np.log(sigmas))

    def part(self, process: int) -> tuple[Index, csc_matrix]:
        """Return the columns of a process and their precision at sigma 1."""
        if process not in self._parts:
            own = self._processes == process
            entries = self._values[own], (self._rows[own], self._columns[own])
            matrix = csc_matrix(entries, shape=(self._size, self._size))
            columns = self._drift_columns if process == DRIFT else self._of_process[process]
            self._parts[process] = columns, matrix
        return self._parts[process]

    def _drift_sigma(self, name: str) -> float:
        """Return one sigma of a drifting error, m or rad."""
        key = _NOISE_KEYS[name]
        unit = math.radians(1.0) if key.endswith("_deg") else 1.0
        return max(self._noise.value(key) * unit, 1e-6)

    def _add_drifts(self, layout: Layout) -> None:
        time_s = max(self._noise.value("correlation_time_s"), 1e-3)
        for name, basis, first in zip(ERRORS, layout.drifts, layout.first_drift, strict=True):
            chain, log_det = gauss_markov(basis, time_s)
            sigma = self._drift_sigma(name)
            self._add(np.arange(first, first + basis.count), chain / sigma**2, DRIFT)
            self._log_det += log_det - 2.0 * basis.count * math.log(sigma)

    def _add_pointing(self, layout: Layout) -> None:
        count = layout.pointing.count
        columns = np.arange(layout.first_pointing, layout.first_pointing + 3 * count)
        chain, log_det = gauss_markov(layout.pointing, max(POINTING_TIME_S, layout.pointing.step_s))
        for axis in range(3):
            self._add(columns[axis * count :][:count], chain, POINTING)
            self._log_det += log_det
        self._ranks[POINTING], self._of_process[POINTING] = len(columns), columns

    def _add_boxes(self, layout: Layout) -> None:
        columns: list[Index] = []
        for first, basis in zip(layout.first_box, layout.boxes, strict=True):
            chain, log_det = gauss_markov(basis, BOX_TIME_S)
            for axis in range(2):
                columns.append(np.arange(basis.count) + first + axis * basis.count)
                self._add(columns[-1], chain, BOX)
                self._log_det += log_det
            self._ranks[BOX] += 2 * basis.count
        self._of_process[BOX] = np.concatenate(columns)

    def _add_paths(self, layout: Layout) -> None:
        paths = zip(layout.first_path, layout.paths, strict=True)
        for robot, (first, path) in enumerate(paths, start=FIRST_ROBOT):
            for axis in range(2):
                own = np.arange(path.count) + first + axis * path.count
                self._add(own, path.rough, robot)
                self._add(own, np.outer(path.middle, path.middle) / ANYWHERE_M**2, FIXED)
            self._ranks[robot] = 2 * (path.count - 1)
            self._log_det += 2.0 * path.log_det
            self._of_process[robot] = np.arange(first, first + 2 * path.count)

    def _add(self, columns: Index, block: Array, process: int) -> None:
        """Add a dense block of the precision."""
        row, column = np.nonzero(block)
        kinds = np.full(len(row), process)
        self._entries.append((columns[row], columns[column], block[row, column], kinds))
