# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the unknowns put the boxes, and the derivatives of that by each unknown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from aerial_gnss_ros.calibration.geometry import Boxes, Predicted, predicted
from aerial_gnss_ros.calibration.layout import Layout
from aerial_gnss_ros.calibration.motion import Motion, Poses, Stamps
from aerial_gnss_ros.calibration.pose_errors import ERRORS
from aerial_gnss_ros.calibration.unknowns import CONSTANTS, FIRST_ERROR, FIX_DELAY, FOCAL, LATENCY

Array = NDArray[np.float64]


class MeasurementModel:
    """The boxes of some images, associated with robots, as a function of the unknowns.

    Args:
        motion: poses.
        stamps_ns: (m,) of the images.
        boxes: of these images, all with a robot.
        tracks: (n,) robots, from 0 on.
        layout: of the unknowns.
        centres: (robots, 2) that paths are relative to, m.
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

    def places(self, unknowns: Array) -> Array:
        """Return where the robots are at each box, (n, 2) m."""
        found = unknowns[self._path_columns]
        along: Array = np.einsum("nak,nk->na", found, self._path_weights)
        return self.centres[self.tracks] + along

    def poses(self, unknowns: Array) -> Poses:
        """Return the images' poses as telemetry has them."""
        return self._motion.at(self.stamps_ns, float(unknowns[LATENCY]), float(unknowns[FIX_DELAY]))

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

    def jacobian(self, found: Predicted, weight: Array) -> csr_matrix:
        """Return the derivatives (2 n, size) of the prediction, each box times its weight (n,)."""
        entries = self._entries(found) * weight[:, None, None]
        count, _, width = entries.shape
        bounds = np.arange(0, 2 * count * width + 1, width)
        return csr_matrix(
            (entries.reshape(-1), self._columns.reshape(-1), bounds),
            shape=(2 * count, self.layout.size),
        )

    def gradient_by_errors(self, force: Array) -> Array:
        """Return the gradient (size,) of forces (n, 6) on the pose's errors at each box."""
        layout, gradient = self.layout, np.zeros(self.layout.size)
        for number, name in enumerate(ERRORS):
            own = force[:, number, None]
            basis, first = layout.drifts[number], layout.first_drift[number]
            np.add.at(gradient, first + basis.columns, own * basis.weights)
            if name in CONSTANTS:
                gradient[FIRST_ERROR + CONSTANTS.index(name)] += float(np.sum(own))
        for axis in range(3):
            first = layout.first_pointing + axis * layout.pointing.count
            own = force[:, 3 + axis, None]
            np.add.at(
                gradient, first + layout.pointing.columns, own * layout.pointing_weights[axis]
            )
        return gradient

    def _errors(self, unknowns: Array) -> Array:
        """Return the pose's errors (n, 6) at each box."""
        layout, at = self.layout, self.boxes.images
        errors = np.zeros((len(self.tracks), len(ERRORS)))
        for number, name in enumerate(ERRORS):
            basis, first = layout.drifts[number], layout.first_drift[number]
            drift = unknowns[first + basis.columns] * basis.weights
            errors[:, number] = drift.sum(axis=1)
            if name in CONSTANTS:
                errors[:, number] += unknowns[FIRST_ERROR + CONSTANTS.index(name)]
        for axis in range(3):
            first = layout.first_pointing + axis * layout.pointing.count
            pointing = unknowns[first + layout.pointing.columns] * layout.pointing_weights[axis]
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
        for first, basis, path in zip(layout.first_box, layout.boxes, layout.paths, strict=True):
            for axis in range(2):
                columns[path.rows, axis] = first + axis * basis.count + basis.columns
            weights[path.rows] = basis.weights
        return columns, weights

    def _all_columns(self) -> NDArray[np.intp]:
        """Return the unknowns (n, 2, width) that each box's u and v depend on."""
        layout, count = self.layout, len(self.tracks)
        constants = np.arange(FIRST_ERROR + len(CONSTANTS))
        parts = [np.broadcast_to(constants, (count, 2, len(constants)))]
        for basis, first in zip(layout.drifts, layout.first_drift, strict=True):
            parts.append(_twice(first + basis.columns))
        for axis in range(3):
            first = layout.first_pointing + axis * layout.pointing.count
            parts.append(_twice(first + layout.pointing.columns))
        parts += [_twice(self._path_columns[:, axis]) for axis in range(2)]
        parts.append(self._box_columns)
        return np.concatenate(parts, axis=2)

    def _entries(self, found: Predicted) -> Array:
        """Return the derivatives (n, 2, width) by these unknowns."""
        layout = self.layout
        first = [found.by_latency, found.by_fix_delay, found.by_focal]
        parts = [one[:, :, None] for one in first]
        parts.append(found.by_error[:, :, [ERRORS.index(name) for name in CONSTANTS]])
        parts += [
            found.by_error[:, :, k, None] * basis.weights[:, None, :]
            for k, basis in enumerate(layout.drifts)
        ]
        parts += [
            found.by_error[:, :, 3 + k, None] * weights[:, None, :]
            for k, weights in enumerate(layout.pointing_weights)
        ]
        path = self._path_weights[:, None, :]
        parts += [found.by_place[:, :, axis, None] * path for axis in range(2)]
        parts.append(np.broadcast_to(self._box_weights[:, None, :], (len(path), 2, 2)))
        return np.nan_to_num(np.concatenate(parts, axis=2))


def _twice(columns: NDArray[np.intp]) -> NDArray[np.intp]:
    return np.broadcast_to(columns[:, None, :], (len(columns), 2, columns.shape[1]))
