# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pose of the camera."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CameraPose:
    """Position and orientation of the camera at the time of the scene.

    Attributes:
        stamp_ns: time of the scene (image stamp less `camera.latency_s`), ns.
        latitude: of the camera itself (lever arm applied), rad, WGS84.
        longitude: rad, WGS84.
        height: camera above the water, m.
        altitude: camera above the WGS84 ellipsoid, m; NaN if the datum is unknown.
        enu_from_camera: (3, 3) camera FLU in ENU at the camera.
        fix_covariance: (2, 2) horizontal East, North covariance that the fix reports, m², or None.
        oldest_age_s: largest distance in time from the scene to a sample used, s.
        interpolation: (6,) variances by interpolation between samples: East, North, height (m²),
            rotation about East, North, Up (rad²).
        gaps_s: (6,) time between these samples, s: as long do these errors last.
    """

    stamp_ns: int
    latitude: float
    longitude: float
    height: float
    altitude: float
    enu_from_camera: Array
    fix_covariance: Array | None = None
    oldest_age_s: float = 0.0
    interpolation: Array = field(default_factory=lambda: np.zeros(6))
    gaps_s: Array = field(default_factory=lambda: np.zeros(6))

    def interpolation_noise(self, passed_s: float) -> Array:
        """Return the (6,) variances that stand for interpolation where images count as independent.

        Images between the same samples share an error: together they count for one.

        Args:
            passed_s: time since the image before, s; 0 without one.
        """
        if not passed_s > 0.0:
            return self.interpolation
        shared: Array = self.interpolation * np.maximum(self.gaps_s / passed_s, 1.0)
        return shared
