# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout of a recording's unknowns.

After the constants (`unknowns.py`) come functions of time, all Gaussian processes on knots
(`processes.py`, `prior.py`): drifts of the platform's errors; pointing errors, which are the
camera's motion that telemetry misses between samples; each robot's path; and errors of a robot's
boxes that last for seconds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.pose_errors import ERRORS
from aerial_gnss_ros.calibration.processes import PATH_KNOT_S, LinearBasis, Path
from aerial_gnss_ros.calibration.unknowns import CONSTANTS, FIRST_ERROR, FIRST_ROBOT, GLOBALS

Array = NDArray[np.float64]
Index = NDArray[np.intp]

BOX_KNOT_S = 1.5
MOST_DRIFT, MOST_BOX = 400, 80


class Layout:
    """Index of each unknown, and its weight at each box.

    Args:
        t: (n,) times of the boxes, s.
        tracks: (n,) robots, all from 0 on.
        step_s: between the knots of pointing errors.
        smoothing_s: shortest time scale that the poses resolve, by the names of ERRORS.
        sizes: (n, 3) of the pointing errors at each box, about each axis, over their sigma.

    Attributes:
        drifts: knots of the drift of each of ERRORS.
        pointing: knots of the pointing errors.
        pointing_weights: (n, 2) of the latter about each of the three axes.
        paths: of the robots.
        boxes: knots of the errors of each robot's boxes.
        first_drift, first_pointing, first_path, first_box: first of their columns.
        size: number of unknowns.
    """

    def __init__(
        self, t: Array, tracks: Index, step_s: float, smoothing_s: dict[str, float], sizes: Array
    ) -> None:
        self.drifts = [
            LinearBasis.of(t, max(smoothing_s[name], step_s), MOST_DRIFT) for name in ERRORS
        ]
        self.pointing = LinearBasis.of(t, step_s, len(np.unique(t)) + 1)
        self.pointing_weights = [size[:, None] * self.pointing.weights for size in sizes.T]
        rows = [np.flatnonzero(tracks == robot) for robot in range(int(tracks.max()) + 1)]
        self.paths = [Path.of(t, own, max(PATH_KNOT_S, 1.5 * step_s)) for own in rows]
        self.boxes = [LinearBasis.of(t[own], BOX_KNOT_S, MOST_BOX) for own in rows]
        counts = [basis.count for basis in self.drifts]
        self.first_drift = [GLOBALS + sum(counts[:number]) for number in range(len(ERRORS))]
        self.first_pointing = GLOBALS + sum(counts)
        at = self.first_pointing + 3 * self.pointing.count
        self.first_path, self.first_box = [], []
        for path in self.paths:
            self.first_path.append(at)
            at += 2 * path.count
        for basis in self.boxes:
            self.first_box.append(at)
            at += 2 * basis.count
        self.size = at

    @property
    def processes(self) -> int:
        """How many processes have a sigma that is estimated."""
        return FIRST_ROBOT + len(self.paths)

    def mean_of(self, name: str) -> Array:
        """Return (size,): the linear function that is an error's mean over the recording."""
        pick = np.zeros(self.size)
        pick[FIRST_ERROR + CONSTANTS.index(name)] = 1.0
        number = ERRORS.index(name)
        basis, first = self.drifts[number], self.first_drift[number]
        pick[first : first + basis.count] = basis.table().mean(axis=0)
        return pick
