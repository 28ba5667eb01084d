# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Splines through telemetry, smoothed by the errors that the noise set states.

A latency is found by comparing boxes with poses at other times. Telemetry errors between samples
(white noise, drifts) look like motion, and a fit would take them for information on the latency:
biased and overconfident. So only the part of the motion that exceeds the stated errors is used.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.interpolation import InterpolationError, from_every_other
from aerial_gnss_ros.calibration.pose_errors import error_axes_of
from aerial_gnss_ros.calibration.smoothing import adapted, penalised, penalty
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.gimbal import Reference
from aerial_gnss_ros.core.georeferencing.covariance import white_rotation

Array = NDArray[np.float64]

REFERENCE_S = 1.0
"""Rotations slower than this are removed before a camera's roll, pitch and heading are smoothed,
s."""


class TelemetrySmoother:
    """Splines through samples with the noise set's errors.

    Args:
        noise: the noise set.
        reference: of the gimbal's orientation.

    Attributes:
        times_s: longest of the smoothing times of each column, by input.
        place_error: variance of interpolated East and North, m².
        turn_error: variance of interpolated roll, pitch and heading, rad².
    """

    def __init__(self, noise: Noise, reference: str) -> None:
        time_s = max(noise.value("correlation_time_s"), 1e-3)

        def drift(key: str) -> float:
            scale = math.radians(1.0) if key.endswith("_deg") else 1.0
            return 2.0 * (noise.value(key) * scale) ** 2 / time_s

        white = np.sqrt(white_rotation(noise, Reference(reference)))
        angles = drift("gimbal_roll_deg"), drift("gimbal_pitch_deg"), drift("heading_deg")
        self._angles = list(zip(angles, white, strict=True))
        self.times_s: dict[str, list[float]] = {}
        self.place_error = InterpolationError([noise.value("gnss_white_m")] * 2)
        self.turn_error = InterpolationError(list(white))
        self._level = drift("gnss_offset_m"), noise.value("gnss_white_m")
        self._height = drift("height_m"), noise.value("height_white_m")

    def level(self, t: Array, values: Array) -> BSpline:
        """Return East and North."""
        self.place_error.add(t, values - from_every_other(t, values))
        return self._smoothed("level", t, values, [self._level] * 2)

    def height(self, t: Array, values: Array) -> BSpline:
        """Return Up."""
        return self._smoothed("height", t, values, [self._height])

    def lever(self, t: Array, values: Array) -> BSpline:
        """Return the camera's position relative to the antenna, as smooth as its angles."""
        return self._smoothed("lever", t, values, [(1e-6, 1e-3)] * 3)

    def turn(self, t: Array, values: Array) -> BSpline:
        """Return quaternions, not of unit length; each angle is smoothed by its own error.

        Angles are relative to a slow rotation, because roll, pitch and heading are undefined when
        the camera looks straight down.
        """
        flips = np.sum(values[1:] * values[:-1], axis=1) < 0.0
        values = values.copy()
        values[1:] *= np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)[:, None]
        _, off = _angles(values, from_every_other(t, values))
        self.turn_error.add(t, off)
        slow = penalised(t, values, np.full(4, penalty(t, REFERENCE_S)))
        base = Rotation.from_quat(slow(t))
        axes, angles = _angles(values, slow(t))
        found = self._smoothed("turn", t, angles, self._angles)(t)
        whole = (Rotation.from_rotvec(np.einsum("nij,nj->ni", axes, found)) * base).as_quat()
        signs = np.where(np.sum(whole * values, axis=1) < 0.0, -1.0, 1.0)
        return make_interp_spline(t, whole * signs[:, None], k=3)

    def _smoothed(
        self, name: str, t: Array, values: Array, errors: list[tuple[float, float]]
    ) -> BSpline:
        found, times_s = adapted(t, values, errors)
        before = self.times_s.get(name, times_s)
        self.times_s[name] = [max(pair) for pair in zip(before, times_s, strict=True)]
        return found


def _angles(quaternions: Array, base: Array) -> tuple[Array, Array]:
    """Return the error axes (n, 3, 3) of base quaternions, and the angles (n, 3) about them."""
    turn = Rotation.from_quat(base)
    axes = error_axes_of(turn.as_matrix())
    turned = (Rotation.from_quat(quaternions) * turn.inv()).as_rotvec()
    return axes, np.asarray(np.einsum("nji,nj->ni", axes, turned))
