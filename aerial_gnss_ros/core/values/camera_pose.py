# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the camera is and how it stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CameraPose:
    """Where the camera was and how it stood at the time of the scene.

    Attributes:
        stamp_ns: time of the scene (image stamp less `camera.latency_s`), ns.
        latitude: of the camera itself (lever arm applied), rad, WGS84.
        longitude: rad, WGS84.
        height: camera above the water, m.
        altitude: camera above the WGS84 ellipsoid, m; NaN when the datum is unknown.
        enu_from_camera: (3, 3) camera FLU in ENU at the camera.
        fix_covariance: (2, 2) horizontal East, North covariance that the fix reports, m², or
            None when it reports none.
        oldest_age_s: largest distance in time from the scene to a sample used, s.
    """

    stamp_ns: int
    latitude: float
    longitude: float
    height: float
    altitude: float
    enu_from_camera: Array
    fix_covariance: Array | None = None
    oldest_age_s: float = 0.0
