# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimate whose covariance is the bound, of a flight's own telemetry and boxes.

It is the Kalman filter of all boxes of all drones, linearised at the truth, which is given the true
share of the receivers' offsets: no filter that is told less can do this. Its use is to take luck
out of a flight's error. In the linear Gaussian model the best estimate's error, of covariance B, is
independent of all that was measured, hence also of any other estimate. So for an estimate that is
apart from the best one by d and states the covariance P, given what was measured, the expected
squared error is tr B + |d|², and the expected normalised one is tr(P⁻¹ B) + dᵀ P⁻¹ d: what the
truth happened to be, such as the receivers' offset, which no filter can know, is not in them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.predicted_pixels import Linear, linearise
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.evaluation.bound import Recursion, TrueDrone, TrueFrame

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredFrame:
    """What a drone measured at the time of a `TrueFrame`.

    Attributes:
        pose: of the camera, by telemetry.
        errors: (9,) true `PLATFORM` corrections of its slow errors.
        pixels: (n, 2) boxes of all robots, px; of those that are not seen it does not matter what.
    """

    pose: CameraPose
    errors: Array
    pixels: Array


@dataclass(frozen=True)
class BestEstimates:
    """Best estimates at the images of one drone, of n robots.

    Attributes:
        positions: (images, n, 2) East, North, m; NaN before first seen.
        covariances: (images, n, 2, 2) of their errors: the bound, m².
    """

    positions: Array
    covariances: Array


def best_estimates(
    drones: Sequence[TrueDrone],
    measured: Sequence[Sequence[MeasuredFrame]],
    local: LocalMap,
    share: float,
) -> list[BestEstimates]:
    """Return the best estimates of several drones together, for each drone at its images.

    Args:
        drones: as for `joint_bound`.
        measured: of each image of each drone.
        local: the frame `map`.
        share: true part of the variance of the receivers' offsets that is common.
    """
    recursion = _Followed(drones, measured, local, share)
    limits = recursion.run()
    return [
        BestEstimates(positions, limit[:, :, :2, :2])
        for positions, limit in zip(recursion.positions, limits, strict=True)
    ]


class _Followed(Recursion):
    """The recursion with its mean, which is kept beside: `state` is linearised at the truth.

    Attributes:
        positions: as in `BestEstimates`, of each drone.
    """

    def __init__(
        self,
        drones: Sequence[TrueDrone],
        measured: Sequence[Sequence[MeasuredFrame]],
        local: LocalMap,
        share: float,
    ) -> None:
        super().__init__(drones, local, share)
        self._measured, self._local = measured, local
        self.positions = [np.full((len(one.frames), self.count, 2), np.nan) for one in drones]
        self._errors = np.zeros((len(drones), COUNT))
        self._robots = np.zeros((0, 4))  # by `state.joint.rows`
        self._apart = np.zeros((0, 2))  # of these positions from the truth, at an image

    def predict(self, seconds: float) -> None:
        self.state.joint.robots[:] = self._robots
        super().predict(seconds)
        self._robots = self.state.joint.robots.copy()
        self._errors *= [model.decay(seconds) for model in self.models]

    def image(self, d: int, k: int, frame: TrueFrame, sight: CameraView) -> None:
        self._apart = self._robots[:, :2] - frame.positions[self.state.joint.rows]
        super().image(d, k, frame, sight)
        self.positions[d][k, self.state.joint.rows] = self._robots[:, :2]

    def update(self, d: int, k: int, slots: Indices, pixels: Array, sight: CameraView) -> Outcome:
        _, before = self.state.ordered()
        rows, places = self.state.joint.rows[slots], self.state.joint.robots[slots, :2].copy()
        outcome = super().update(d, k, slots, pixels, sight)
        linear, m = outcome.linear, len(slots)
        residual = self._noise(d, k, rows, places, linear)
        residual -= np.einsum("mij,mj->mi", linear.by_place, self._apart[slots])
        by_state = np.zeros((m, 2, len(before)))
        by_state[:, :, COUNT * d : COUNT * (d + 1)] = linear.by_platform
        for one, slot in enumerate(slots):
            first = self._errors.size + 4 * int(slot)
            by_state[one, :, first : first + 2] = linear.by_place[one]
        gained = np.linalg.solve(outcome.spread, residual.ravel())
        change = before @ by_state.reshape(2 * m, -1).T @ gained
        self._errors += change[: self._errors.size].reshape(-1, COUNT)
        self._robots += change[self._errors.size :].reshape(-1, 4)
        return outcome

    def begin(self, d: int, k: int, rows: Indices, places: Array, sight: CameraView) -> Linear:
        linear = super().begin(d, k, rows, places, sight)
        noise = self._noise(d, k, rows, places, linear)
        fresh = np.zeros((len(rows), 4))
        fresh[:, :2] = places + np.linalg.solve(linear.by_place, noise[:, :, None])[:, :, 0]
        self._robots = np.concatenate([self._robots, fresh])
        return linear

    def _noise(self, d: int, k: int, rows: Indices, places: Array, linear: Linear) -> Array:
        """Return by how much pixels (m, 2) differ from where this drone's errors put them, px.

        White noise of boxes and telemetry, and what the estimate takes the errors of this drone
        for wrongly.
        """
        own = self._measured[d][k]
        camera, pose = self.drones[d].camera, MapPose.of(own.pose, self._local)
        view = CameraView.of(camera, pose, np.zeros(6), 0.0)
        expected = linearise(view, own.errors, places).pixels
        wrong = self._errors[d] - own.errors
        noise: Array = own.pixels[rows] - expected - linear.by_platform @ wrong
        return noise
